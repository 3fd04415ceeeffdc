"""Writes a CycloneDX bill of materials from `cargo metadata`: the crates that the program contains, without those of tests.

Usage: cargo metadata --format-version 1 --filter-platform TARGET | bill-of-materials.py VERSION COMMIT TARGET
"""

import json
import sys


def component(package):
    """One crate with its licence and check sum name."""
    found = {
        "type": "library",
        "name": package["name"],
        "version": package["version"],
        "purl": f"pkg:cargo/{package['name']}@{package['version']}",
    }
    if package["license"]:
        found["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
    return found


def main():
    version, commit, target = sys.argv[1:]
    metadata = json.load(sys.stdin)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    root = metadata["resolve"]["root"]
    reached, waiting = set(), [root]
    while waiting:
        here = waiting.pop()
        for dependency in nodes[here]["deps"]:
            is_used = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if is_used and dependency["pkg"] not in reached:
                reached.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    crates = sorted((packages[one] for one in reached), key=lambda one: (one["name"], one["version"]))
    json.dump(
        {
            "bomFormat": "CycloneDX",
            "specVersion": "1.5",
            "version": 1,
            "metadata": {
                "component": {
                    "type": "application",
                    "name": "gelpad",
                    "version": version,
                    "properties": [
                        {"name": "commit", "value": commit},
                        {"name": "target", "value": target},
                    ],
                }
            },
            "components": [component(package) for package in crates],
        },
        sys.stdout,
        indent=1,
    )
    print()


main()
