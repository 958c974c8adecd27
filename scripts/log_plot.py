"""Draws curves on two logarithmic axes as SVG, without any library."""

import math

COLORS = ["#c0392b", "#2471a3", "#1e8449", "#7d3c98", "#b9770e", "#34495e"]
WIDTH, HEIGHT = 640, 440
LEFT, RIGHT, TOP, BOTTOM = 70, 20, 40, 55


def write_svg(path, title, x_label, y_label, curves):
    """Draws `curves`, a list of (name, [(x, y), ...]). Points with a coordinate of 0 or below are left out."""
    curves = [(name, [(x, y) for x, y in points if x > 0 and y > 0]) for name, points in curves]
    curves = [(name, points) for name, points in curves if points]
    x_axis = Axis([x for _, points in curves for x, _ in points], LEFT, WIDTH - RIGHT)
    y_axis = Axis([y for _, points in curves for _, y in points], HEIGHT - BOTTOM, TOP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        text(WIDTH / 2, 22, title, anchor="middle", size=15),
    ]
    for value, label in x_axis.ticks():
        x = x_axis.place(value)
        parts.append(line(x, TOP, x, HEIGHT - BOTTOM, "#e4e4e4" if label else "#f4f4f4"))
        parts.append(text(x, HEIGHT - BOTTOM + 16, label, anchor="middle"))
    for value, label in y_axis.ticks():
        y = y_axis.place(value)
        parts.append(line(LEFT, y, WIDTH - RIGHT, y, "#e4e4e4" if label else "#f4f4f4"))
        parts.append(text(LEFT - 6, y + 4, label, anchor="end"))
    parts.append(f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH - LEFT - RIGHT}" height="{HEIGHT - TOP - BOTTOM}" '
                 'fill="none" stroke="#555"/>')
    parts.append(text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 14, x_label, anchor="middle"))
    middle = (TOP + HEIGHT - BOTTOM) / 2
    parts.append(f'<g transform="rotate(-90 18 {middle:.1f})">{text(18, middle, y_label, anchor="middle")}</g>')
    for index, (name, points) in enumerate(curves):
        color = COLORS[index % len(COLORS)]
        places = [(x_axis.place(x), y_axis.place(y)) for x, y in points]
        joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        parts.append(f'<polyline points="{joined}" fill="none" stroke="{color}" stroke-width="1.6"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{color}"/>' for x, y in places]
        # Errors fall to the right, so the upper right corner is free.
        y = TOP + 18 + 17 * index
        parts.append(line(WIDTH - RIGHT - 172, y - 4, WIDTH - RIGHT - 150, y - 4, color, 2.5))
        parts.append(text(WIDTH - RIGHT - 144, y, name))
    path.write_text("\n".join(parts) + "\n</svg>\n")


def text(x, y, words, anchor="start", size=12):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}">{words}</text>'


def line(x1, y1, x2, y2, color, width=1.0):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{color}" stroke-width="{width}"/>'


class Axis:
    """Maps values to places between `start` and `end`."""

    def __init__(self, values, start, end):
        low, high = math.log10(min(values)), math.log10(max(values))
        margin = 0.06 * max(high - low, 0.5)
        self.low, self.high = low - margin, high + margin
        self.start, self.end = start, end

    def place(self, value):
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def ticks(self):
        """Returns the values with a grid line, and their labels."""
        labelled = (1, 2, 5) if self.high - self.low < 2.5 else (1,)
        for decade in range(math.floor(self.low), math.ceil(self.high) + 1):
            for digit in range(1, 10):
                value = digit * 10.0**decade
                if self.low <= math.log10(value) <= self.high:
                    yield value, f"{value:g}" if digit in labelled else ""
