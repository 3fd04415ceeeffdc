"""Walks gelpad's window over the accessibility bus (AT-SPI), as Orca does: every view is chosen, each of its controls has a name and an
action, Tab reaches them in the order of the tree, and the pad says what is pressed. Prints a line for each view and each mistake; ends
with 1 if there is a mistake.

Needs a session bus with at-spi2-core, a display with xdotool, and gir1.2-atspi-2.0.
"""

import os
import subprocess
import sys
import time

os.environ["NO_AT_BRIDGE"] = "1"
import gi

gi.require_version("Atspi", "2.0")
from gi.repository import Atspi, GLib

Atspi.init()
State = Atspi.StateType
PATIENCE_S = 60
# Roles of controls.
CONTROLS = {"push button", "toggle button", "page tab", "check box", "radio button", "combo box", "slider", "spin button"}
CONTROLS |= {"text", "entry", "canvas"}
mistakes = []


def wait(look, what):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        try:
            found = look()
        except GLib.GError:
            # A node that is gone, or an answer that took too long on a busy machine.
            found = None
        if found:
            return found
        time.sleep(0.05)
    report()
    sys.exit(f"no {what} within {PATIENCE_S} s")


def report():
    for mistake in mistakes:
        print(f"MISTAKE: {mistake}")


def below(node):
    found = [node]
    for index in range(node.get_child_count()):
        child = node.get_child_at_index(index)
        if child is not None:
            found += below(child)
    return found


def application():
    desktop = Atspi.get_desktop(0)
    children = (desktop.get_child_at_index(index) for index in range(desktop.get_child_count()))
    return next((child for child in children if child and child.get_name() == "gelpad"), None)


def has(node, state):
    return node.get_state_set().contains(state)


def retried(check, *arguments):
    """A check that is made again if a node was gone, or an answer took too long, meanwhile."""
    for _ in range(5):
        known = len(mistakes)
        try:
            return check(*arguments)
        except GLib.GError as error:
            del mistakes[known:]
            print(f"again: {error}")
            time.sleep(1)
    sys.exit("the window does not answer")


def said(node):
    return f"{node.get_role_name()} {node.get_name()!r}"


def expect(right, mistake):
    if not right:
        mistakes.append(mistake)


def key(*names):
    subprocess.run(["xdotool", "key", "--clearmodifiers", *names], check=True)


def window_id():
    found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "^gelpad$"], capture_output=True, text=True)
    return found.stdout.split()[:1]


def focused(frame):
    """The control with the focus, if any."""
    return next((node for node in below(frame) if node.get_role_name() != "frame" and has(node, State.FOCUSED)), None)


def reached_by_tab(frame, controls):
    """Indices of the controls in the order in which Tab reaches them, until one comes again."""
    order = []
    node = None
    for _ in range(2 * len(controls) + 10):
        before = node
        key("Tab")

        def moved():
            now = focused(frame)
            return now if now is not None and now != before else None

        node = wait(moved, "control to which Tab moves the focus")
        index = next((index for index, one in enumerate(controls) if one == node), None)
        if index is None:
            continue
        if index in order:
            break
        order.append(index)
    return order


def check_view(frame, tab):
    name = tab.get_name()
    expect(tab.do_action(0), f"{name}: the tab has no action")
    wait(lambda: has(tab, State.SELECTED), f"selected tab {name}")
    time.sleep(0.5)
    nodes = wait(lambda: [node for node in below(frame) if node.get_role_name() != "frame"], "nodes")
    controls = [node for node in nodes if has(node, State.FOCUSABLE) and has(node, State.SENSITIVE)]
    for node in controls:
        expect(any(char.isalnum() for char in node.get_name()), f"{name}: {said(node)} has no name with letters")
        expect(node.get_role_name() in CONTROLS or node.get_role_name() == "label", f"{name}: {said(node)} has no role of a control")
    selected = [other.get_name() for other in nodes if other.get_role_name() == "page tab" and has(other, State.SELECTED)]
    expect(selected == [name], f"{name}: selected are {selected}")
    for node in nodes:
        expect(not any(char in "⏸⏺⏹▶◀⟲⟳🗖✖✔●ℹ⚠" for char in node.get_name()), f"{name}: {said(node)} has a symbol")
    order = reached_by_tab(frame, controls)
    share = len(order) / max(len(controls), 1)
    expect(share >= 0.9, f"{name}: Tab reaches {len(order)} of {len(controls)}")
    steps_back = sum(later < earlier for earlier, later in zip(order, order[1:]))
    expect(steps_back <= 1, f"{name}: the focus jumps: {[controls[index].get_name() for index in order]}")
    print(f"{name}: {len(nodes)} nodes, {len(controls)} controls, Tab reaches {len(order)} in the order of the tree but for {steps_back} steps")


def check_pad(frame):
    """A region pressed with the keyboard is told by the pad and by the region."""
    pad = next(node for node in below(frame) if node.get_role_name() == "canvas" and node.get_name().startswith("Pad"))
    regions = [node.get_name() for node in below(pad)[1:]]
    expect(len(regions) >= 4, f"the pad has the regions {regions}")
    wait(lambda: focused(frame) == pad or key("Tab"), "focus on the pad")
    subprocess.run(["xdotool", "keydown", "1"], check=True)
    down = lambda: [node.get_name() for node in below(pad)[1:] if node.get_name().endswith(", held")]
    wait(down, "region that is down")
    expect("no touch" not in pad.get_name(), f"the pad says {pad.get_name()!r} while {down()} is down")
    print(f"while 1 is held: {pad.get_name()!r}, {down()[0]!r}")
    subprocess.run(["xdotool", "keyup", "1"], check=True)
    wait(lambda: not down(), "end of the press")


def main():
    app = wait(application, "application called gelpad")
    frame = wait(lambda: app.get_child_count() and app.get_child_at_index(0), "window")
    expect(frame.get_name() == "gelpad", f"the window is called {frame.get_name()!r}")
    window = wait(window_id, "window on the display")[0]
    subprocess.run(["xdotool", "windowmove", window, "0", "0", "windowsize", window, "1280", "800", "windowfocus", window], check=True)
    tabs = wait(lambda: [node for node in below(frame) if node.get_role_name() == "page tab"], "tabs")
    expect(len(tabs) == 7, f"{len(tabs)} views")
    wait(lambda: any("100 frames/s" in node.get_name() for node in below(frame)), "frames")
    for tab in tabs:
        retried(check_view, frame, tab)
    tabs[0].do_action(0)
    wait(lambda: has(tabs[0], State.SELECTED), "first view")
    retried(check_pad, frame)
    report()
    sys.exit(1 if mistakes else 0)


main()
