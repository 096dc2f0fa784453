#!/usr/bin/env python3
"""What other choices of a policy would have given, from the validation rows of a run: scripts/validation-choices.py DIR...

DIR is a results directory of traffic signals with unpacked records. Every figure is the mean over its trainings of
delay / delay of the baseline, on validation seeds that took no part in the choice. Only policies that were validated on all
seeds, the last one among them, can be compared on many of them; how often validation is due is compared on two seeds, of
which one chooses and the other measures.
"""

import json
import sys
from collections import defaultdict
from pathlib import Path
from statistics import fmean

MARGINS = (0.0, 0.05, 0.1, 0.2)
INTERVALS = (1, 2, 4, 8)
PATIENCE = (3, 6)


def trainings(folder):
    """Yields method, delay of the baseline and delays by validated episode and seed, in the order of the records."""
    baseline, validated = {}, []
    for path in sorted(Path(folder, "done").rglob("*.jsonl")):
        first, *rows = map(json.loads, path.read_text().splitlines())
        if first["method"] == "baseline" and first["outcome"] == "ok":
            baseline[first["point"]] = first["metrics"]["delay_s"]
        delays = defaultdict(dict)
        for row in rows:
            if row["kind"] == "validation":
                delays[row["episode"]][row["seed"]] = row["metrics"]["delay_s"]
        if delays:
            validated.append((first["method"], first["point"], delays))
    for method, point, delays in validated:
        yield method, baseline[point], delays


def chosen(delays, candidates, seeds, margin):
    """Returns the episode with the least delay on some seeds; the last one unless another is better by the margin."""
    mean = lambda episode: fmean(delays[episode][seed] for seed in seeds)
    last, best = max(delays), min(candidates, key=mean)
    return best if mean(best) < mean(last) * (1 - margin) else last


def choices(delays):
    """Yields the name of each choice and the delay that it gives."""
    episodes, last = sorted(delays), max(delays)
    step = min(b - a for a, b in zip(episodes, episodes[1:]))
    two = list(delays[min(episodes, key=lambda episode: len(delays[episode]))])
    finalists = [episode for episode in episodes if len(delays[episode]) > len(two)] or [last]
    further = [seed for seed in delays[last] if seed not in two] or two
    on = lambda episode, seeds: fmean(delays[episode][seed] for seed in seeds)
    yield "finalists: last policy", on(last, further)
    for margin in MARGINS:
        yield f"finalists: two seeds, margin {margin:.0%}", on(chosen(delays, finalists, two, margin), further)
        folds = []
        for i in range(len(further)):
            use = two + [further[i], further[(i + 1) % len(further)]]
            rest = [seed for seed in further if seed not in use] or further
            folds.append(on(chosen(delays, finalists, use, margin), rest))
        yield f"finalists: four seeds, margin {margin:.0%}", fmean(folds)
    yield "all: last policy", on(last, two)
    for every in INTERVALS:
        candidates = [episode for episode in episodes if (last - episode) % (every * step) == 0]
        pairs = [(two, two)] if len(two) < 2 else [(two[:1], two[1:]), (two[1:], two[:1])]
        folds = [on(chosen(delays, candidates, a, 0.05), b) for a, b in pairs]
        yield f"all: every {every * step} episodes, one seed, margin 5%", fmean(folds)
    for patience in PATIENCE:
        folds, played = [], []
        for a, b in pairs:
            best, since = episodes[0], 0
            for episode in episodes[1:]:
                better = on(episode, a) < on(best, a)
                best, since = (episode, 0) if better else (best, since + 1)
                if since == patience:
                    break
            # A training that is not stopped compares its best policy with the last one.
            kept = chosen(delays, episodes, a, 0.05) if episode == last else best
            folds.append(on(kept, b))
            played.append(episode / last)
        yield f"all: patience {patience}, one seed", fmean(folds)
        yield f"all: patience {patience}, share of the episodes", fmean(played)


for folder in sys.argv[1:] or sys.exit(__doc__):
    table = defaultdict(lambda: defaultdict(list))
    for method, baseline, delays in trainings(folder):
        for name, delay in choices(delays):
            table[name][method].append(delay if "share" in name else delay / baseline)
    methods = sorted({method for row in table.values() for method in row})
    print(folder, *methods, sep="\t")
    for name, row in table.items():
        print(name, *(f"{fmean(row[method]):.3f}" for method in methods), sep="\t")
