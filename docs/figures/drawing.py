"""SVG figures that are legible on light and dark pages and at the width of a phone."""

from __future__ import annotations

from html import escape

STYLE = """
text { font: 15px system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif; fill: #1f2933; }
.small { font-size: 13px; fill: #52606d; }
.bold { font-weight: 600; }
.action { fill: #b4400f; font-weight: 600; }
.page { fill: #ffffff; }
.box { fill: #f3f6f9; stroke: #7b8794; stroke-width: 1.5; }
.zone { fill: #eaf6ee; stroke: #3f9d63; stroke-width: 1.5; }
.part { fill: #ffffff; stroke: #52606d; stroke-width: 1.5; }
.warm { fill: #fde8dd; stroke: #c2571f; stroke-width: 1.5; }
.cold { fill: #e1effb; stroke: #2878b8; stroke-width: 1.5; }
.act { fill: none; stroke: #c2571f; stroke-width: 2; stroke-dasharray: 5 4; }
.air { fill: none; stroke: #2878b8; stroke-width: 2.5; }
.return { fill: none; stroke: #8a94a0; stroke-width: 2.5; }
.line { fill: none; stroke: #52606d; stroke-width: 1.5; }
.grid { fill: none; stroke: #dde3e9; stroke-width: 1; }
.one { fill: none; stroke: #2878b8; stroke-width: 2.5; }
.two { fill: none; stroke: #c2571f; stroke-width: 2.5; }
.three { fill: none; stroke: #3f9d63; stroke-width: 2.5; }
@media (prefers-color-scheme: dark) {
text { fill: #e6e9ed; }
.small { fill: #aab4bf; }
.action { fill: #ffab7d; }
.page { fill: #171b20; }
.box { fill: #232a32; stroke: #8a97a5; }
.zone { fill: #1c3326; stroke: #5cc287; }
.part { fill: #171b20; stroke: #aab4bf; }
.warm { fill: #42281b; stroke: #ff9d66; }
.cold { fill: #182e42; stroke: #6cb4ec; }
.act { stroke: #ffab7d; }
.air { stroke: #6cb4ec; }
.return { stroke: #7d8894; }
.line { stroke: #aab4bf; }
.grid { stroke: #333c46; }
.one { stroke: #6cb4ec; }
.two { stroke: #ffab7d; }
.three { stroke: #5cc287; }
}
"""

#: Colors of arrow heads on light and on dark pages, by the class of the line.
HEADS = {"act": ("#c2571f", "#ffab7d"), "air": ("#2878b8", "#6cb4ec"), "return": ("#8a94a0", "#7d8894")}
HEADS["line"] = ("#52606d", "#aab4bf")


class Figure:
    """A drawing, with its width and height in pixels and a ``title`` for screen readers."""

    def __init__(self, width: int, height: int, title: str):
        self.width, self.height = width, height
        heads, colors = "", ""
        for kind, (light, dark) in HEADS.items():
            heads += (
                f'<marker id="{kind}" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="9" markerHeight="9" '
                f'markerUnits="userSpaceOnUse" orient="auto"><path class="{kind}-head" d="M0 0L10 5L0 10z"/></marker>'
            )
            colors += f".{kind}-head {{ fill: {light}; }}\n"
            colors += f"@media (prefers-color-scheme: dark) {{ .{kind}-head {{ fill: {dark}; }} }}\n"
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" role="img" aria-label="{escape(title)}">',
            f"<title>{escape(title)}</title><style>{STYLE}{colors}</style><defs>{heads}</defs>",
            f'<rect class="page" width="{width}" height="{height}" rx="8"/>',
        ]

    def box(self, x: float, y: float, width: float, height: float, text: str = "", kind: str = "box") -> None:
        """Draws a rectangle with centered lines of text."""
        self.parts.append(f'<rect class="{kind}" x="{x}" y="{y}" width="{width}" height="{height}" rx="6"/>')
        lines = text.split("\n") if text else []
        for number, line in enumerate(lines):
            middle = y + height / 2 + 5 + 19 * (number - (len(lines) - 1) / 2)
            self.text(x + width / 2, middle, line, "bold" if number == 0 and len(lines) > 1 else "", "middle")

    def text(self, x: float, y: float, text: str, kind: str = "", anchor: str = "start") -> None:
        """Draws a line of text; ``y`` is its baseline."""
        self.parts.append(f'<text class="{kind}" x="{x:g}" y="{y:g}" text-anchor="{anchor}">{escape(text)}</text>')

    def line(self, *points: tuple[float, float], kind: str = "line", head: bool = True) -> None:
        """Draws a polyline, with an arrow head at its end unless ``head`` is false."""
        path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        end = f' marker-end="url(#{kind})"' if head and kind in HEADS else ""
        self.parts.append(f'<path class="{kind}" d="{path}"{end}/>')

    def axes(self, frame: Frame, x_label: str, y_label: str) -> None:
        """Draws the axes of a chart with grid lines and labels."""
        for value, label in frame.x_ticks:
            x = frame.x(value)
            self.line((x, frame.top), (x, frame.bottom), kind="grid")
            self.text(x, frame.bottom + 18, label, "small", "middle")
        for value, label in frame.y_ticks:
            y = frame.y(value)
            self.line((frame.left, y), (frame.right, y), kind="grid")
            self.text(frame.left - 8, y + 5, label, "small", "end")
        self.line((frame.left, frame.top), (frame.left, frame.bottom), (frame.right, frame.bottom), head=False)
        self.text((frame.left + frame.right) / 2, frame.bottom + 40, x_label, "small", "middle")
        self.text(frame.left, frame.top - 10, y_label, "small")

    def svg(self) -> str:
        """Returns the text of the SVG file."""
        return "\n".join([*self.parts, "</svg>", ""])


class Frame:
    """The area of a chart: its edges in pixels and the ranges of its linear scales."""

    def __init__(
        self,
        edges: tuple[float, float, float, float],
        x: tuple[float, float],
        y: tuple[float, float],
        x_ticks: list[tuple[float, str]],
        y_ticks: list[tuple[float, str]],
    ):
        self.left, self.top, self.right, self.bottom = edges
        self.x_scale, self.y_scale = x, y
        self.x_ticks, self.y_ticks = x_ticks, y_ticks

    def x(self, value: float) -> float:
        """Returns the horizontal pixel of a value."""
        low, high = self.x_scale
        return self.left + (value - low) / (high - low) * (self.right - self.left)

    def y(self, value: float) -> float:
        """Returns the vertical pixel of a value."""
        low, high = self.y_scale
        return self.bottom - (value - low) / (high - low) * (self.bottom - self.top)
