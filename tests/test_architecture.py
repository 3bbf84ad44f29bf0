"""The house rules that a linter cannot hold: sizes, frozen values, exits, documented names."""

import ast
import dis
import importlib
import inspect
import pkgutil
import re
import runpy
import subprocess
from collections import Counter
from collections.abc import Callable, Iterator
from enum import Enum
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher
from pydantic import BaseModel

import echoplan
from echoplan.settings import Settings

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
# Ceilings for what the house style (CONTRIBUTING.md) would have none of: lower them when you remove some.
SHORT_HELPERS = 82
SHARED_CONSTANTS = 41
CROWDED_FUNCTIONS = 291


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


def positional(function: ast.AST) -> int:
    """Number of parameters that may be passed by position."""
    assert isinstance(function, FUNCTIONS)
    every = [*function.args.posonlyargs, *function.args.args]
    return sum(argument.arg not in ("self", "cls") for argument in every)


def offenders(sizes: dict[str, int], limit: int) -> list[str]:
    return [f"{where}: {size}" for where, size in sizes.items() if size > limit]


def is_kernel(function: ast.AST) -> bool:
    """Whether numba compiles it: a compiled function takes what it needs and branches as its algorithm does."""
    assert isinstance(function, FUNCTIONS)
    return any(ast.unparse(decorator) in ("compiled", "inlined") for decorator in function.decorator_list)


def module_of(path: Path) -> ModuleType:
    return importlib.import_module(".".join(path.relative_to(SOURCE.parent).with_suffix("").parts))


def decorated(name: str) -> set[Any]:
    """The functions of the package with a decorator."""
    return {
        getattr(module_of(path), node.name)
        for path in FILES
        for node in parsed(path)
        if isinstance(node, ast.FunctionDef) and name in map(ast.unparse, node.decorator_list)
    }


def used_by_python(path: Path) -> set[Any]:
    """What the functions and classes of a file use by its name, except for those that numba compiles."""
    kernels = {node.name for node in parsed(path) if isinstance(node, ast.FunctionDef) and is_kernel(node)}
    names, waiting = set[str](), [compile(path.read_text(encoding="utf-8"), path, "exec")]
    while waiting:
        code = waiting.pop()
        names |= {each.argval for each in dis.get_instructions(code) if each.opname in ("LOAD_GLOBAL", "LOAD_NAME")}
        waiting += [each for each in code.co_consts if isinstance(each, CodeType) and each.co_name not in kernels]
    values = [vars(module_of(path)).get(name) for name in names]
    for node in parsed(path):
        if isinstance(node, ast.ImportFrom) and node.col_offset and str(node.module).startswith("echoplan"):
            values += [vars(importlib.import_module(str(node.module))).get(each.name) for each in node.names]
    return {value for value in values if isinstance(value, FunctionType | Dispatcher)}


def test_python_calls_compiled_functions_and_only_these_call_inlined_ones() -> None:
    used = set().union(*map(used_by_python, FILES))
    assert not used & decorated("inlined")
    assert decorated("compiled") <= used


def test_at_most_60_functions_have_machine_code_of_their_own() -> None:
    assert len(decorated("compiled")) <= 60


def test_no_function_is_longer_than_80_lines() -> None:
    assert not offenders({where: body_lines(node) for where, node in nodes(FUNCTIONS)}, 80)


def test_no_function_outside_kernels_is_more_complex_than_8() -> None:
    assert not offenders({where: complexity(node) for where, node in nodes(FUNCTIONS) if not is_kernel(node)}, 8)


def test_at_most_two_parameters_are_positional_where_there_are_more_than_six() -> None:
    def positional_of_many(node: ast.AST) -> int:
        assert isinstance(node, FUNCTIONS)
        return positional(node) if positional(node) + len(node.args.kwonlyargs) > 6 else 0

    # The command line is exempt: its parameters are its manual page.
    functions = [(where, node) for where, node in nodes(FUNCTIONS) if "/cli/" not in where and not is_kernel(node)]
    assert not offenders({where: positional_of_many(node) for where, node in functions}, 2)


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


def test_estimates_are_immutable() -> None:
    joint = [path for path in FILES if "joint" in path.relative_to(SOURCE).parts]
    changed = []
    for path in joint:
        # Exempt: the public mapper, which collects sweeps; Multipath, which computes emissions on first use; and the
        # logging handler of the trace.
        initialisers = {
            id(each)
            for node in parsed(path)
            if isinstance(node, ast.ClassDef)
            for method in node.body
            if isinstance(method, FUNCTIONS)
            and (method.name == "__init__" or node.name in ("JointMapper", "Multipath", "_Collector"))
            for each in ast.walk(method)
        }
        for node in parsed(path):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                is_own = ast.unparse(node.value) == "self" and id(node) in initialisers
                if not is_own:
                    changed.append(f"{path.relative_to(ROOT)}:{node.lineno} {ast.unparse(node)}")
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("copy.copy", "object.__setattr__"):
                changed.append(f"{path.relative_to(ROOT)}:{node.lineno} {ast.unparse(node.func)}")
    assert not changed


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
    # Every settings class derives from Settings; only the depth below it counts.
    def depth(kind: type) -> int:
        own = [base for base in kind.__mro__ if base.__module__.startswith("echoplan") and base is not Settings]
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


def test_public_functions_and_classes_have_a_docstring() -> None:
    public = [
        (where, node)
        for where, node in nodes((*FUNCTIONS, ast.ClassDef))
        if not getattr(node, "name", "_").startswith("_")
    ]
    missing = [where for where, node in public if ast.get_docstring(node) is None]  # type: ignore[arg-type]
    assert len(missing) <= 0.05 * len(public), missing


def parameters(node: ast.AST) -> set[str]:
    """Names of the parameters of a function, or of the constructor of a class."""
    if isinstance(node, ast.ClassDef):
        own = [each for each in node.body if isinstance(each, FUNCTIONS) and each.name == "__init__"]
        fields = (each.target for each in node.body if isinstance(each, ast.AnnAssign))
        return parameters(own[0]) if own else {ast.unparse(each) for each in fields}
    assert isinstance(node, FUNCTIONS)
    rest = [each for each in (node.args.vararg, node.args.kwarg) if each is not None]
    return {each.arg for each in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs, *rest]}


def test_documented_parameters_exist() -> None:
    wrong = []
    for where, node in nodes((*FUNCTIONS, ast.ClassDef)):
        text = ast.get_docstring(node) or ""  # type: ignore[arg-type]
        section = re.search(r"Parameters\n-+\n(.*?)(?:\n\n[A-Z]\w+\n-+|\Z)", text, flags=re.DOTALL)
        heads = re.findall(r"^([*\w, ]+) : ", section[1], flags=re.MULTILINE) if section else []
        named = {name for head in heads for name in re.findall(r"\w+", head)}
        wrong += [f"{where}: {name}" for name in named - parameters(node)]
    assert not wrong


def exported_by_packages() -> list[tuple[str, object]]:
    """Names that users import from a package; exceptions, enumerations and settings document themselves."""
    found: list[tuple[str, object]] = []
    for module in pkgutil.walk_packages(echoplan.__path__, "echoplan."):
        package = importlib.import_module(module.name)
        for name in getattr(package, "__all__", []) if module.ispkg else []:
            value = getattr(package, name)
            is_own = isinstance(value, type) and issubclass(value, (BaseException, Enum, BaseModel))
            if not is_own and (inspect.isclass(value) or inspect.isfunction(value)):
                found.append((f"{module.name}.{name}", value))
    return found


@pytest.mark.parametrize(("name", "value"), [pytest.param(*each, id=each[0]) for each in exported_by_packages()])
def test_the_parameters_of_what_a_package_exports_are_documented(name: str, value: Callable[..., object]) -> None:
    if getattr(value, "_is_protocol", False) or not inspect.signature(value).parameters:
        return
    assert re.search(r"^(Parameters|Attributes)\n-+$", inspect.getdoc(value) or "", flags=re.MULTILINE), name


def test_no_more_private_helpers_of_three_lines_with_one_caller_than_there_are() -> None:
    short = []
    for path in FILES:
        names = Counter(
            node.id if isinstance(node, ast.Name) else node.attr
            for node in parsed(path)
            if isinstance(node, (ast.Name, ast.Attribute))
        )
        short += [
            f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"
            for node in parsed(path)
            if isinstance(node, FUNCTIONS)
            and re.match("_[a-z]", node.name)
            and not node.decorator_list
            and body_lines(node) <= 3
            and names[node.name] == 1
        ]
    assert len(short) <= SHORT_HELPERS, short


def constants_of_joint() -> Iterator[tuple[str, str, ast.expr, bool]]:
    """Module-level constants of the estimator: place, name, value, and whether a comment stands above or beside it."""
    for path in (path for path in FILES if "joint" in path.parts):
        lines = path.read_text(encoding="utf-8").splitlines()
        for node in ast.parse("\n".join(lines)).body:
            if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None:
                continue
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            values = node.value.elts if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple) else []
            around = lines[node.lineno - 1 : node.end_lineno]
            is_explained = lines[node.lineno - 2].startswith("#") or any("#" in line for line in around)
            for name, value in zip(names, values or [node.value] * len(names), strict=True):
                if ast.unparse(name).isupper():
                    yield f"{path.relative_to(ROOT)}:{node.lineno}", ast.unparse(name), value, is_explained


def test_no_more_private_constants_of_joint_share_a_name_than_do() -> None:
    values: dict[str, set[str]] = {}
    for _, name, value, _ in constants_of_joint():
        if name.startswith("_"):
            values.setdefault(name, set()).add(ast.unparse(value))
    shared = [name for name, different in values.items() if len(different) > 1]
    assert len(shared) <= SHARED_CONSTANTS, shared


def test_every_number_of_joint_has_a_comment() -> None:
    bare = [
        f"{where} {name}"
        for where, name, value, is_explained in constants_of_joint()
        if not is_explained
        and any(isinstance(node, ast.Constant) and type(node.value) in (int, float) for node in ast.walk(value))
    ]
    assert not bare


def test_no_more_functions_have_three_positional_parameters_than_do() -> None:
    crowded = [
        where
        for where, node in nodes(FUNCTIONS)
        if "/cli/" not in where and not is_kernel(node) and positional(node) > 2
    ]
    assert len(crowded) <= CROWDED_FUNCTIONS, crowded


def test_every_mutant_changes_a_line_that_stands_once() -> None:
    mutants = runpy.run_path(str(ROOT / "tests" / "mutants.py"))
    lost = [
        name
        for name, mutant in mutants["MUTANTS"].items()
        if (SOURCE / "joint" / mutant.file).read_text(encoding="utf-8").count(mutant.old) != 1
        or not all((ROOT / "tests" / "unit" / "joint" / each).is_file() for each in mutant.tests)
    ]
    assert not lost


def test_every_rule_of_the_ablation_switches_something_off_that_exists() -> None:
    rules = runpy.run_path(str(ROOT / "benchmarks" / "ablation.py"))["RULES"]
    names = [name for changes in rules.values() for name in changes]
    assert names
    assert all(pkgutil.resolve_name(name) is not None for name in names)
    assert [name for name in names if not is_loaded(*name.rsplit(".", 1))] == []


def is_loaded(place: str, name: str) -> bool:
    """Return True unless a module never reads this name of its own; names of classes may be read elsewhere."""
    module = pkgutil.resolve_name(place)
    if not isinstance(module, ModuleType):
        return True
    loaded = (node for node in ast.walk(ast.parse(inspect.getsource(module))) if isinstance(node, ast.Name))
    return any(node.id == name and isinstance(node.ctx, ast.Load) for node in loaded)


def test_a_new_type_of_landmark_takes_a_short_patch_of_the_modules_that_the_architecture_names() -> None:
    patch, described = ROOT / "tests" / "thin_pole.patch", (ROOT / "docs" / "architecture.md").read_text("utf-8")
    lines = patch.read_text(encoding="utf-8").splitlines()
    modules = {line[len("+++ b/src/echoplan/") : -len(".py")].replace("/", ".") for line in lines if line[:3] == "+++"}
    how = next(line for line in described.splitlines() if line.startswith("- **A landmark type**"))
    assert len(lines) < 120
    assert all(f"`{module}`" in how for module in modules), modules
    # ``tests/new_landmark.py`` maps a room with it.
    subprocess.run(["git", "apply", "--check", str(patch)], cwd=ROOT, check=True)


def test_no_file_names_the_place_where_it_was_written() -> None:
    found = []
    for path in [*FILES, *sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md"]:
        text = path.read_text(encoding="utf-8")
        found += [f"{path.relative_to(ROOT)}: {word}" for word in ("/work/", "session", "/.library") if word in text]
    assert not found


def test_no_file_of_the_repository_is_larger_than_200_kb() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("this is no git repository")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True)
    paths = [ROOT / name for name in listed.stdout.split("\0") if name]
    assert [path.name for path in paths if path.exists() and path.stat().st_size > 200_000] == []
