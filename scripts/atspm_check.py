#!/usr/bin/env python3
"""Feeds the folder that `tsc-family events` wrote to the package atspm, and prints arrivals on green and split failures.

  pip install atspm "duckdb<2"
  python3 scripts/atspm_check.py results/smoke-events [--expected counts.csv]

--expected names a table of phase, arrivals and arrivals on green of the only signal, counted in another way; the exit code is 1
where atspm's differ by more than a vehicle per phase and quarter of an hour, as at the edges of greens. It is 77 where atspm is missing.
"""

import argparse
import csv
import pathlib
import sys

try:
    from atspm import SignalDataProcessor
except ImportError as error:
    print(f"skipped: {error}; pip install atspm 'duckdb<2'", file=sys.stderr)
    sys.exit(77)

MEASURES = [
    {"name": "arrival_on_green", "params": {"latency_offset_seconds": 0}},
    {
        "name": "split_failures",
        "params": {
            "red_time": 5,
            "red_occupancy_threshold": 0.8,
            "green_occupancy_threshold": 0.8,
            "by_approach": True,
            "by_cycle": False,
        },
    },
    {"name": "terminations", "params": {}},
]


def measured(folder):
    """Returns arrivals and arrivals on green by phase, and the rows of split failures and terminations."""
    settings = {
        "raw_data": str(folder / "events.csv"),
        "detector_config": str(folder / "detectors.csv"),
        "bin_size": 15,
        "verbose": 0,
        "aggregations": MEASURES,
    }
    with SignalDataProcessor(**settings) as processor:
        processor.load()
        processor.aggregate()
        rows = lambda query: processor.conn.execute(query).fetchall()
        arrivals = rows(
            "SELECT DeviceId, Phase, SUM(Total_Actuations)::INT, SUM(ROUND(Total_Actuations * Percent_AOG))::INT, COUNT(*)"
            " FROM arrival_on_green GROUP BY DeviceId, Phase ORDER BY DeviceId, Phase"
        )
        failures = rows(
            "SELECT DeviceId, Phase, SUM(Split_Failure)::INT, ROUND(AVG(Green_Occupancy), 2), ROUND(AVG(Red_Occupancy), 2)"
            " FROM split_failures GROUP BY DeviceId, Phase ORDER BY DeviceId, Phase"
        )
        ends = rows(
            "SELECT DeviceId, Phase, PerformanceMeasure, SUM(Total)::INT FROM terminations GROUP BY ALL ORDER BY ALL"
        )
    return arrivals, failures, ends


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--expected", type=pathlib.Path)
    args = parser.parse_args()
    arrivals, failures, ends = measured(args.folder)
    print("device,phase,arrivals,on_green,share")
    for device, phase, all_of_them, on_green, _ in arrivals:
        print(f"{device},{phase},{all_of_them},{on_green},{on_green / all_of_them:.3f}")
    print("\ndevice,phase,split_failures,green_occupancy,red_occupancy")
    for row in failures:
        print(",".join(map(str, row)))
    print("\ndevice,phase,termination,times")
    for row in ends:
        print(",".join(map(str, row)))
    if args.expected is None:
        return 0
    with args.expected.open() as file:
        expected = {int(r["phase"]): (int(r["arrivals"]), int(r["on_green"])) for r in csv.DictReader(file)}
    found = {phase: (total, on_green, bins) for _, phase, total, on_green, bins in arrivals}
    wrong = 0
    for phase, (total, on_green) in sorted(expected.items()):
        there = found.get(phase, (0, 0, 1))
        bound = there[2]
        if abs(there[0] - total) > bound or abs(there[1] - on_green) > bound:
            print(f"phase {phase}: {there[:2]} by atspm, {total, on_green} expected", file=sys.stderr)
            wrong += 1
    if not expected or wrong:
        return 1
    print(f"\nas expected: {len(expected)} phases", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
