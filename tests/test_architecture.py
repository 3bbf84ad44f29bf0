"""The house rules that a linter cannot hold: sizes, frozen values, exits, documented names."""

import ast
import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import echoplan

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "echoplan"
FILES = sorted(SOURCE.rglob("*.py"))
BRANCHES = (
    ast.If,
    ast.For,
    ast.While,
    ast.ExceptHandler,
    ast.IfExp,
    ast.comprehension,
    ast.BoolOp,
    ast.match_case,
)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def parsed(path: Path) -> list[ast.AST]:
    """All nodes of a file."""
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def nodes(kind: type[ast.AST] | tuple[type[ast.AST], ...]) -> Iterator[tuple[str, ast.AST]]:
    for path in FILES:
        for node in parsed(path):
            if isinstance(node, kind):
                yield (
                    f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)} {getattr(node, 'name', '')}",
                    node,
                )


def body_lines(function: ast.AST) -> int:
    assert isinstance(function, FUNCTIONS)
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    return (body[-1].end_lineno or 0) - body[0].lineno + 1 if body else 0


def complexity(function: ast.AST) -> int:
    return 1 + sum(isinstance(node, BRANCHES) for node in ast.walk(function))


def offenders(sizes: dict[str, int], limit: int) -> list[str]:
    return [f"{where}: {size}" for where, size in sizes.items() if size > limit]


def is_kernel(function: ast.AST) -> bool:
    """Whether numba compiles it: a compiled function takes what it needs and branches as its algorithm does."""
    assert isinstance(function, FUNCTIONS)
    return any("compiled" in ast.unparse(decorator) for decorator in function.decorator_list)


def test_no_function_is_longer_than_what_is_read_in_one_go() -> None:
    assert not offenders({where: body_lines(node) for where, node in nodes(FUNCTIONS)}, 80)


def test_no_function_outside_kernels_branches_too_much() -> None:
    assert not offenders({where: complexity(node) for where, node in nodes(FUNCTIONS) if not is_kernel(node)}, 8)


def test_at_most_two_parameters_are_positional_where_there_are_more_than_six() -> None:
    def positional(node: ast.AST) -> int:
        assert isinstance(node, FUNCTIONS)
        every = [*node.args.posonlyargs, *node.args.args]
        named = [argument for argument in every if argument.arg not in ("self", "cls")]
        return len(named) if len(named) + len(node.args.kwonlyargs) > 6 else 0

    # The command line is exempt: its parameters are its manual page.
    functions = [(where, node) for where, node in nodes(FUNCTIONS) if "/cli/" not in where and not is_kernel(node)]
    assert not offenders({where: positional(node) for where, node in functions}, 2)


def test_no_file_is_too_long() -> None:
    sizes = {str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    assert not offenders(sizes, 400)
    assert np.quantile(list(sizes.values()), 0.9) <= 250


def test_every_dataclass_is_frozen() -> None:
    loose = []
    for where, node in nodes(ast.ClassDef):
        assert isinstance(node, ast.ClassDef)
        for decorator in node.decorator_list:
            text = ast.unparse(decorator)
            if text.startswith("dataclass") and "frozen=True" not in text:
                loose.append(where)
    assert not loose


def test_no_module_state_no_global_no_exit_no_print() -> None:
    found = [where for where, _ in nodes((ast.Global, ast.Nonlocal))]
    found += [
        where
        for where, node in nodes(ast.Call)
        if isinstance(node, ast.Call)
        and "/cli/" not in where
        and ast.unparse(node.func) in ("sys.exit", "exit", "print")
    ]
    assert not found


def test_errors_are_caught_broadly_nowhere() -> None:
    broad = []
    for where, node in nodes(ast.ExceptHandler):
        assert isinstance(node, ast.ExceptHandler)
        if node.type is None or ast.unparse(node.type) in ("Exception", "BaseException"):
            broad.append(where)
    assert not broad


def test_inheritance_is_flat() -> None:
    def depth(kind: type) -> int:
        own = [base for base in kind.__mro__ if base.__module__.startswith("echoplan")]
        return len(own)

    deep = [
        f"{kind.__module__}.{kind.__name__}"
        for module in modules()
        for kind in vars(importlib.import_module(module)).values()
        if isinstance(kind, type)
        and kind.__module__ == module
        and depth(kind) > (3 if module.endswith("errors") else 2)
    ]
    assert not deep


def modules() -> list[str]:
    return [module.name for module in pkgutil.walk_packages(echoplan.__path__, "echoplan.")]


@pytest.mark.parametrize("name", modules())
def test_exported_names_are_sorted_exist_and_are_documented(name: str) -> None:
    module = importlib.import_module(name)
    exported = getattr(module, "__all__", None)
    if exported is None:
        # A package that only gathers its modules exports nothing by itself.
        assert Path(module.__file__ or "").name in ("__init__.py", "__main__.py"), f"{name} has no __all__"
        return
    for item in exported:
        value = getattr(module, item)
        if callable(value):
            assert getattr(value, "__doc__", None), f"{name}.{item} has no docstring"


def test_every_public_function_and_class_is_documented() -> None:
    public = [
        (where, node)
        for where, node in nodes((*FUNCTIONS, ast.ClassDef))
        if not getattr(node, "name", "_").startswith("_")
    ]
    missing = [where for where, node in public if ast.get_docstring(node) is None]  # type: ignore[arg-type]
    assert len(missing) <= 0.05 * len(public), missing


def test_nothing_committed_tells_of_the_workshop() -> None:
    told = []
    for path in [*FILES, *sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md"]:
        text = path.read_text(encoding="utf-8")
        told += [f"{path.relative_to(ROOT)}: {word}" for word in ("/work/", "session", ".library") if word in text]
    assert not told
