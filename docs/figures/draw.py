"""Draws the figures of the concept pages: `python docs/figures/draw.py` writes the SVG files beside it."""

from __future__ import annotations

import math
from pathlib import Path

from drawing import Figure, Frame

#: ISO 7726:1998, table 2, class C: the accuracy of an air temperature sensor that the resolved score adds, K.
RESOLUTION = 0.2


def step_loop() -> Figure:
    figure = Figure(560, 430, "A step: an action is clamped, raised by the ventilation interlock, and simulated")
    figure.box(20, 20, 240, 62, "Agent\nsees 23 values, returns 10")
    figure.box(300, 110, 240, 62, "1 Bounds\neach value is clamped", "part")
    figure.box(300, 206, 240, 62, "2 Ventilation interlock\nraises flows for people", "part")
    figure.box(
        300,
        302,
        240,
        100,
        "3 EnergyPlus\none zone time step:\n5 minutes of weather, walls,\npeople, coils and fans",
        "zone",
    )
    figure.box(20, 330, 240, 72, "4 Read\nvariables, meters", "part")
    figure.box(20, 206, 240, 76, "5 Reward\ntargets seen before the step,\nstate and energy after it", "part")
    figure.line((260, 51), (420, 51), (420, 108), kind="act")
    figure.text(340, 40, "action", "action")
    figure.line((420, 172), (420, 204), kind="act")
    figure.line((420, 268), (420, 300), kind="act")
    figure.line((300, 366), (262, 366))
    figure.line((140, 330), (140, 284))
    figure.line((140, 206), (140, 84))
    figure.text(150, 128, "observation,", "bold")
    figure.text(150, 148, "reward, info", "bold")
    return figure


def step_timeline() -> Figure:
    figure = Figure(560, 446, "Time: warm-up days, then zone time steps of five minutes")
    figure.text(20, 32, "An episode", "bold")
    for day in range(3):
        figure.box(20 + 70 * day, 46, 64, 44, "day 1", "warm")
    figure.text(232, 74, "…")
    figure.line((262, 40), (262, 112), head=False)
    for day in range(3):
        figure.box(274 + 70 * day, 46, 64, 44, f"day {day + 1}", "cold")
    figure.text(486, 74, "…")
    figure.text(20, 112, "warm-up: day 1 over and over,", "small")
    figure.text(20, 130, "under a small fixed controller", "small")
    figure.text(274, 112, "run period: the agent acts", "small")
    figure.text(274, 130, "reset: a copy made at this midnight", "small")

    figure.text(20, 178, "Zone time steps", "bold")
    left, width = 40, 120
    for step in range(4):
        figure.box(left + width * step, 206, width, 48, "5 min", "cold")
        figure.line((left + width * step, 196), (left + width * step, 272), head=False)
    for step in range(4):
        x = left + width * step
        figure.text(x + 4, 196, f"a{step}", "action")
    figure.line((left + 480, 196), (left + 480, 272), head=False)
    for step in range(5):
        figure.text(left + width * step, 290, f"o{step}", "bold", "middle")
    notes = (
        "o: observation, the state now, and targets and occupancy for the next step",
        "a: action, held until the next observation",
        "reward: temperatures at the end of a step, targets seen at its beginning,",
        "and the energy of the step",
        "",
        "EnergyPlus can divide a zone time step into shorter system time steps.",
        "Here it does not: systems are solved once a step, in up to 20 iterations.",
    )
    for number, note in enumerate(notes):
        figure.text(20, 320 + 18 * number, note, "small")
    return figure


def duct(figure: Figure, y: float, parts: list[tuple[str, str]], left: float, right: float) -> None:
    """Components in a row along an air stream from left to right."""
    width, gap = 62.0, (right - left - 62.0 * len(parts)) / (len(parts) + 1)
    x = left
    for text, kind in parts:
        figure.line((x, y), (x + gap, y), kind="air")
        figure.box(x + gap, y - 24, width, 48, text, kind)
        x += gap + width
    figure.line((x, y), (right, y), kind="air")


def unitary() -> Figure:
    figure = Figure(560, 400, "A unitary system: one unit with fan and coils for one zone")
    figure.box(350, 40, 190, 120, "Zone\ntemperature, target\nand occupancy: seen", "zone")
    figure.line((350, 74), (96, 74), (96, 218), kind="return")
    figure.text(150, 66, "return air", "small")
    figure.line((130, 74), (130, 36), kind="return")
    figure.text(120, 28, "exhaust", "small", "middle")
    figure.text(12, 210, "outdoor air", "small")
    figure.line((12, 244), (64, 244), kind="air")
    figure.box(66, 220, 60, 48, "mixer", "part")
    duct(figure, 244, [("fan", "part"), ("cool", "cold"), ("heat", "warm")], 126, 440)
    figure.line((440, 244), (470, 244), (470, 162), kind="air")
    figure.text(478, 218, "supply air", "small")
    figure.line((180, 318), (180, 272), kind="act")
    figure.text(20, 338, "supply air flow", "action")
    figure.text(20, 357, "0 to design flow, kg/s", "small")
    figure.line((372, 318), (372, 272), kind="act")
    figure.line((372, 318), (282, 318), (282, 272), kind="act")
    figure.text(290, 338, "supply air temperature", "action")
    figure.text(290, 357, "10 to 45 °C; the coils do what it takes", "small")
    figure.text(20, 386, "Outdoor air is not an action: the interlock opens it while people are in the zone.", "small")
    return figure


def air_loop() -> Figure:
    figure = Figure(560, 520, "A central air loop with terminals: one air handler for many zones")
    figure.line((12, 90), (64, 90), kind="air")
    figure.text(12, 62, "outdoor air", "small")
    figure.box(66, 66, 60, 48, "mixer", "part")
    duct(figure, 90, [("fan", "part"), ("cool", "cold"), ("heat", "warm")], 126, 450)
    figure.line((450, 90), (530, 90), (530, 200), (60, 200), kind="air", head=False)
    figure.text(456, 80, "supply", "small")
    figure.line((40, 430), (40, 104), (64, 104), kind="return")
    for number, name in enumerate(("Zone 1", "Zone 15")):
        x = 70 + 310 * number
        figure.line((x + 65, 200), (x + 65, 226), kind="air")
        figure.box(x + 20, 228, 90, 40, "damper", "part")
        figure.line((x + 65, 268), (x + 65, 286), kind="air")
        figure.box(x + 20, 288, 90, 40, "reheat", "warm")
        figure.line((x + 65, 328), (x + 65, 346), kind="air")
        figure.box(x, 348, 130, 52, name, "zone")
        figure.line((x + 65, 400), (x + 65, 430), (40, 430), kind="return", head=False)
    for y in (248, 308):
        figure.line((216, y), (182, y), kind="act")
        figure.line((354, y), (398, y), kind="act")
    figure.text(52, 448, "return air", "small")
    figure.text(290, 380, "…", "bold", "middle")
    figure.line((96, 150), (96, 118), kind="act")
    figure.text(60, 170, "outdoor air flow", "action")
    figure.text(60, 188, "kg/s, one for the loop", "small")
    figure.line((400, 150), (400, 118), kind="act")
    figure.text(312, 170, "supply air temperature", "action")
    figure.text(312, 188, "°C, one for the loop", "small")
    figure.text(285, 246, "damper opening", "action", "middle")
    figure.text(285, 264, "0 to 1, each zone", "small", "middle")
    figure.text(285, 306, "heating setpoint", "action", "middle")
    figure.text(285, 324, "°C, each zone", "small", "middle")
    figure.text(52, 480, "One stream of cold air: each zone takes more or less of it,", "small")
    figure.text(52, 498, "and warms its own share again if it needs heat.", "small")
    return figure


def heating_only() -> Figure:
    figure = Figure(560, 190, "A unit heater with its own thermostat")
    figure.box(190, 20, 350, 150, "", "zone")
    figure.text(210, 46, "Zone without cooling", "bold")
    figure.text(210, 66, "such as a storage hall", "small")
    figure.box(210, 90, 120, 60, "thermostat", "part")
    figure.box(400, 90, 120, 60, "unit heater", "warm")
    figure.line((330, 120), (398, 120))
    figure.text(345, 112, "heat", "small")
    figure.line((140, 120), (208, 120), kind="act")
    figure.text(16, 112, "heating setpoint", "action")
    figure.text(16, 132, "°C", "small")
    return figure


def economizer() -> Figure:
    """Mixed air of 23 °C return air with outdoor air between a minimum and all of it, for 13 °C supply air."""
    figure = Figure(560, 330, "An economizer: share of outdoor air in the supply air by outdoor temperature")
    ticks = [(value, f"{value}") for value in range(-20, 41, 10)]
    frame = Frame((60, 40, 530, 260), (-20, 40), (0, 1), ticks, [(0, "0"), (0.5, "50 %"), (1, "100 %")])
    figure.axes(frame, "outdoor air temperature, °C", "outdoor air in the supply air")
    minimum, room, mixed = 0.15, 23.0, 11.5
    points = []
    for tenth in range(-200, 401):
        outdoor = tenth / 10
        share = minimum if outdoor >= room else min(max((room - mixed) / (room - outdoor), minimum), 1.0)
        share = 1.0 if mixed <= outdoor < room else share
        points.append((frame.x(outdoor), frame.y(share)))
    figure.line(*points, kind="one", head=False)
    figure.text(frame.x(-19), frame.y(0.52), "as much as cools", "small")
    figure.text(frame.x(-19), frame.y(0.44), "to the supply air", "small")
    figure.text(frame.x(12), frame.y(0.9), "all of it", "small")
    figure.text(frame.x(24), frame.y(0.26), "too warm: the", "small")
    figure.text(frame.x(24), frame.y(0.18), "minimum", "small")
    return figure


def trim_respond() -> Figure:
    """The reset of one supply air temperature by scripted requests, with the default rates of air loops."""
    respond, trim, step = 6.0, 4.0, 1 / 12
    figure = Figure(560, 390, "Trim and respond: zones request cooling, and the supply air gets colder")
    hours = [(value, f"{value}") for value in range(6, 21, 2)]
    requests = Frame((60, 40, 530, 110), (6, 20), (0, 3), hours, [(0, "0"), (3, "3")])
    supply = Frame((60, 160, 530, 320), (6, 20), (9, 19), hours, [(10, "10"), (14, "14"), (18, "18")])
    figure.axes(requests, "", "zones that request cooling")
    figure.axes(supply, "hour of the day", "supply air temperature, °C")
    first, second, reset = [], [], 0.0
    for number in range(int(14 / step) + 1):
        hour = 6 + number * step
        asking = 3 if 13 <= hour < 14.5 else 1 if 9 <= hour < 9.5 or 11 <= hour < 13 or 16 <= hour < 16.5 else 0
        change = respond * min(asking, 3) if asking else -trim
        reset = min(max(reset + change * step, 0.0), 8.0)
        first.append((requests.x(hour), requests.y(asking)))
        second.append((supply.x(hour), supply.y(18 - reset)))
    figure.line(*first, kind="two", head=False)
    figure.line(*second, kind="one", head=False)
    figure.text(supply.x(14.8), supply.y(10.6), "coldest allowed", "small")
    figure.text(supply.x(17.4), supply.y(14.2), "trim: warmer,", "small")
    figure.text(supply.x(17.4), supply.y(13.0), "4 K an hour", "small")
    figure.text(supply.x(6.3), supply.y(12.2), "respond: colder, 6 K", "small")
    figure.text(supply.x(6.3), supply.y(11.0), "an hour per request", "small")
    return figure


def mdp() -> Figure:
    figure = Figure(560, 250, "Agent and environment, in the terms of reinforcement learning and of control")
    figure.box(30, 80, 190, 90, "Agent\npolicy\n= controller")
    figure.box(340, 80, 190, 90, "Environment\nbuilding, weather,\npeople = plant", "zone")
    figure.line((125, 80), (125, 40), (435, 40), (435, 78), kind="act")
    figure.text(280, 30, "action = manipulated variables", "action", "middle")
    figure.line((435, 170), (435, 210), (125, 210), (125, 172))
    figure.text(280, 200, "observation = measured variables", "", "middle")
    figure.text(280, 232, "reward = minus the cost of the step", "", "middle")
    return figure


def discount() -> Figure:
    """γ^k of a reward k steps of five minutes ahead."""
    figure = Figure(560, 340, "Discount: the weight of a reward by how far it lies ahead")
    ticks = [(value, f"{value}") for value in range(0, 25, 4)]
    frame = Frame((60, 40, 530, 270), (0, 24), (0, 1), ticks, [(0, "0"), (0.5, "0.5"), (1, "1")])
    figure.axes(frame, "hours ahead, in steps of five minutes", "weight of a reward")
    for gamma, kind, label in ((0.9, "three", (1.1, 0.3)), (0.99, "two", (5.4, 0.56)), (0.999, "one", (15, 0.88))):
        points = [(frame.x(k / 12), frame.y(gamma**k)) for k in range(0, 289, 2)]
        figure.line(*points, kind=kind, head=False)
        figure.text(frame.x(label[0]), frame.y(label[1]), f"γ = {gamma}", "bold")
    return figure


def score() -> Figure:
    """Both scores of a policy with an RMS deviation, against a baseline of 0.03 K, in a task without energy."""
    figure = Figure(560, 370, "Score and resolved score by RMS deviation, of a baseline that holds 0.03 K")
    x_ticks = [(value / 10, f"{value / 10:g}") for value in range(0, 6)]
    y_ticks = [(math.log10(value), f"{value:g}") for value in (0.1, 1, 10, 100)]
    frame = Frame((60, 40, 530, 300), (0, 0.5), (-1, 2.5), x_ticks, y_ticks)
    figure.axes(frame, "RMS deviation of the policy, K", "score (logarithmic)")
    baseline = 0.03**2
    deviations = [number / 1000 for number in range(10, 501, 2)]
    plain = [(frame.x(d), frame.y(math.log10(d * d / baseline))) for d in deviations]
    resolved = [
        (frame.x(d), frame.y(math.log10((d * d + RESOLUTION**2) / (baseline + RESOLUTION**2)))) for d in deviations
    ]
    figure.line((frame.left, frame.y(0)), (frame.right, frame.y(0)), kind="line", head=False)
    figure.line(*plain, kind="two", head=False)
    figure.line(*resolved, kind="one", head=False)
    figure.text(frame.x(0.2), frame.y(1.98), "score", "bold")
    figure.text(frame.x(0.33), frame.y(0.24), "resolved score", "bold")
    figure.text(frame.x(0.27), frame.y(-0.2), "1: as good as the baseline", "small")
    return figure


def generalization() -> Figure:
    figure = Figure(560, 430, "Four questions of generalization")
    rows = [
        ("Goal", "same building, other tasks", "constant, occupancy", "random targets"),
        ("Dynamics", "same type, other buildings", "900 houses", "100 other houses"),
        ("Actuators", "same building, other actuators", "5 air flows", "and 5 temperatures"),
        ("Domain", "other types of buildings", "shops", "small offices"),
    ]
    figure.text(165, 32, "trained on", "small", "middle")
    figure.text(425, 32, "tested on", "small", "middle")
    for number, (name, question, train, test) in enumerate(rows):
        y = 44 + 96 * number
        figure.box(30, y, 220, 46, train, "cold")
        figure.box(320, y, 210, 46, test, "warm")
        figure.line((250, y + 23), (318, y + 23))
        figure.text(30, y + 66, name, "bold")
        figure.text(130, y + 66, question, "small")
    return figure


FIGURES = {
    "step-loop": step_loop,
    "step-timeline": step_timeline,
    "unitary": unitary,
    "air-loop": air_loop,
    "heating-only": heating_only,
    "economizer": economizer,
    "trim-respond": trim_respond,
    "mdp": mdp,
    "discount": discount,
    "score": score,
    "generalization": generalization,
}


def main() -> None:
    """Writes every figure."""
    for name, draw in FIGURES.items():
        (Path(__file__).parent / f"{name}.svg").write_text(draw().svg())


if __name__ == "__main__":
    main()
