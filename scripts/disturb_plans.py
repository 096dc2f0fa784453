#!/usr/bin/env python3
"""Disturbs plans at random, for a study of `retime`: writes plans of `nema` with other control and greens to standard output.

usage: scripts/disturb_plans.py REPORT/plans/nema.csv SEED > plans.csv

One intersection after the other becomes pretimed, coordinated on the phases of its first barrier, and actuated. Greens are 30 s, those of
left turns 15 s, times a random factor of 0.5 to 2, and not below the shortest green or walk and clearance. The last phase of the shorter
ring is green until the barrier.
"""
import csv
import itertools
import random
import sys


def split_s(phase):
    return phase["max_green_s"] + int(phase["yellow_s"]) + int(phase["all_red_s"])


def main():
    rows = list(csv.DictReader(open(sys.argv[1], encoding="utf-8", newline="")))
    chance = random.Random(int(sys.argv[2]))
    table = csv.DictWriter(sys.stdout, rows[0], lineterminator="\n")
    table.writeheader()
    controls = itertools.cycle(["pretimed", "coordinated", "actuated"])
    for _, group in itertools.groupby(rows, lambda row: row["intersection"]):
        phases, control, cycle_s = list(group), next(controls), 0
        for barrier in sorted({int(phase["barrier"]) for phase in phases}):
            rings = [[p for p in phases if (p["barrier"], p["ring"]) == (str(barrier), ring)] for ring in "12"]
            rings = [sorted(ring, key=lambda p: int(p["position"])) for ring in rings if ring]
            for phase in itertools.chain(*rings):
                green_s = round((30 if phase["dual_entry"] == "yes" else 15) * chance.uniform(0.5, 2))
                walk_s = int(phase["walk_s"] or 0) + int(phase["clearance_s"] or 0)
                phase["max_green_s"] = max(green_s, int(phase["min_green_s"]), walk_s)
            sums_s = [sum(map(split_s, ring)) for ring in rings]
            for ring, sum_s in zip(rings, sums_s):
                ring[-1]["max_green_s"] += max(sums_s) - sum_s
            cycle_s += max(sums_s)
        first = [p["phase"] for p in phases if p["barrier"] == phases[0]["barrier"] and p["dual_entry"] == "yes"]
        for phase in phases:
            phase |= {"control": control, "split_s": split_s(phase)}
            phase |= {"cycle_s": "" if control == "actuated" else cycle_s}
            table.writerow(phase | {"reference": " ".join(first) if control == "coordinated" else ""})


if __name__ == "__main__":
    main()
