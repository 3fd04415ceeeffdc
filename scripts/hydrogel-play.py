#!/usr/bin/env python3
"""Plays super-mario on two measured skins that no model describes: `gelpad calibrate` learns each from single presses, then a stream in
which the changes of other measured presses are added is replayed, and the keys are compared with the presses.

    scripts/hydrogel-play.py [SEEDS] [SIZES]        defaults: 1,2,3,4,5 and 50,500,2000

The data (no licence: not part of gelpad) is read from $GELPAD_DATA/hydrogel-presses, else ../shared/data; GELPAD names the program to
run. The data holds differences only, so the untouched readings are made up: ten times the largest change of each channel. Noise is white,
60 dB of them; 100 frames/s. A stream has 40 presses of `jump`, 40 to 600 ms, every other one while `left` or `right` is held. Presses
are chosen among those 4 mm or more within their region. A press is right if its key goes down and up within a frame of the finger.
"""
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent.parent
DATA = pathlib.Path(os.environ.get("GELPAD_DATA", HERE / "../shared/data")) / "hydrogel-presses"
GELPAD = os.environ.get("GELPAD", str(HERE / "target/release/gelpad"))
FRAME_MS = 10
INSIDE_MM = 4.0
# Regions of profiles/super-mario.toml as shares of the pad, and their keys.
REGIONS = {
    "key:f": (0.62, 0.20, 0.38, 0.64),
    "key:left": (0.02, 0.32, 0.22, 0.50),
    "key:right": (0.26, 0.32, 0.22, 0.50),
}


def numbers(path):
    return [[float(value) for value in line.split(",")] for line in path.read_text().split("\n") if line]


def play(skin, seed, size, folder):
    changes = numbers(DATA / f"inp_{skin}.csv")
    places = [[1000 * value for value in row[:2]] for row in numbers(DATA / f"out_{skin}.csv")]
    low = [min(place[axis] for place in places) - 2 for axis in (0, 1)]
    places = [[place[axis] - low[axis] for axis in (0, 1)] for place in places]
    sides = [max(place[axis] for place in places) + 2 for axis in (0, 1)]
    channels = len(changes[0])
    untouched = [10 * (max(abs(row[c]) for row in changes) or 1.0) for c in range(channels)]
    chance = random.Random(seed)
    order = list(range(len(changes)))
    chance.shuffle(order)
    train, test = order[:size], order[size:]

    with open(folder / "train.csv", "w") as file:
        file.write("x_mm,y_mm," + ",".join(f"d{c}" for c in range(channels)) + "\n")
        for press in train:
            file.write(",".join(f"{value:.6g}" for value in places[press] + changes[press]) + "\n")
        file.write(",," + ",".join(f"{value:.6g}" for value in untouched) + "\n")

    def inside(press, key):
        x, y, w, h = REGIONS[key]
        start = (x * sides[0], y * sides[1])
        end = ((x + w) * sides[0], (y + h) * sides[1])
        return all(start[k] + INSIDE_MM <= places[press][k] <= end[k] - INSIDE_MM for k in (0, 1))

    in_region = {key: [press for press in test if inside(press, key)] for key in REGIONS}
    pressed, frame = [], 200
    for number in range(40):
        length = chance.choice([4, 6, 10, 20, 40, 60])
        if number % 2:
            key = chance.choice(["key:left", "key:right"])
            pressed.append((key, chance.choice(in_region[key]), frame, frame + length + 30))
            frame += 15
        pressed.append(("key:f", chance.choice(in_region["key:f"]), frame, frame + length))
        frame += length + 40

    with open(folder / "stream.csv", "w") as file:
        file.write("t_ms," + ",".join(f"v{c}" for c in range(channels)) + "\n")
        for number in range(frame):
            down = [changes[press] for _, press, start, end in pressed if start <= number < end]
            values = [u * (1 + chance.gauss(0, 1e-3)) + sum(row[c] for row in down) for c, u in enumerate(untouched)]
            file.write(f"{number * FRAME_MS}," + ",".join(f"{value:.7g}" for value in values) + "\n")

    pad = folder / "skin.toml"
    # A shade larger than the presses' box, so that rounding leaves them on the pad.
    outline = "x".join(f"{side + 0.01:.2f}" for side in sides)
    learning = [GELPAD, "calibrate", "--presses", folder / "train.csv", "--size", outline, "-o", pad]
    learned = subprocess.run(learning, check=True, capture_output=True, text=True)
    said = learned.stderr.split("\n")[0]
    replaying = [GELPAD, "replay", folder / "stream.csv", "--calibration", pad, "--profile", "super-mario"]
    lines = subprocess.run(replaying, check=True, capture_output=True, text=True).stdout.split("\n")
    events = [line.split() for line in lines if line]

    held, keys = {}, []
    for t_ms, what, key in events:
        if what == "press":
            held[key] = float(t_ms)
        else:
            keys.append((key, held.pop(key), float(t_ms)))
    found = right = 0
    for key, _, start, end in pressed:
        start, end = start * FRAME_MS, end * FRAME_MS
        met = [k for k in keys if k[0] == key and k[1] < end and k[2] > start]
        found += bool(met)
        right += len(met) == 1 and abs(met[0][1] - start) <= FRAME_MS and abs(met[0][2] - end) <= FRAME_MS
        keys = [k for k in keys if k not in met]
    return {"presses": len(pressed), "found": found, "right": right, "false": len(keys) + len(held), "said": said}


def main():
    seeds = [int(seed) for seed in (sys.argv[1] if len(sys.argv) > 1 else "1,2,3,4,5").split(",")]
    sizes = [int(size) for size in (sys.argv[2] if len(sys.argv) > 2 else "50,500,2000").split(",")]
    for skin in ("noPattern", "parallel"):
        for size in sizes:
            total = {"presses": 0, "found": 0, "right": 0, "false": 0}
            for seed in seeds:
                with tempfile.TemporaryDirectory() as folder:
                    run = play(skin, seed, size, pathlib.Path(folder))
                print(json.dumps({"skin": skin, "size": size, "seed": seed} | run), flush=True)
                total = {name: total[name] + run[name] for name in total}
            print(
                f"{skin}, {size} presses learned: {total['found']} of {total['presses']} presses found, "
                f"{total['right']} as long as they were within a frame, {total['false']} keys without a press",
                flush=True,
            )


if __name__ == "__main__":
    main()
