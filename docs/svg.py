"""Elements of SVG files as text."""

from xml.sax.saxutils import escape, quoteattr

__all__ = ["element", "label", "page"]


def element(tag: str, *children: str, **attributes: object) -> str:
    """Return an element; ``stroke_width=2`` is the attribute ``stroke-width``, and ``kind_`` is ``kind``."""
    written = "".join(
        f" {name.strip('_').replace('_', '-')}={quoteattr(f'{value:g}' if isinstance(value, float) else str(value))}"
        for name, value in attributes.items()
    )
    return f"<{tag}{written}>{''.join(children)}</{tag}>" if children else f"<{tag}{written}/>"


def label(text: str, x: float, y: float, **attributes: object) -> str:
    """Return a text at a place."""
    return element("text", escape(text), x=float(x), y=float(y), **attributes)


def page(items: list[str], *, width: float, height: float, title: str, unit: str = "") -> str:
    """Return a file: its items, one a line, on white paper."""
    size = f'width="{width:g}{unit}" height="{height:g}{unit}" viewBox="0 0 {width:g} {height:g}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="DejaVu Sans, Verdana, Arial, sans-serif">',
        element("title", escape(title)),
        element("rect", width=float(width), height=float(height), fill="white"),
        *items,
        "</svg>",
    ]
    return "\n".join(lines) + "\n"
