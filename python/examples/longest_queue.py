"""A controller of one's own, ranked beside three of tsc-family's: ``python longest_queue.py [SCENARIO]``."""

import sys

import tsc_family as tf


class Longest(tf.Controller):
    """The phase whose lanes hold the most vehicles that have halted."""

    name = "longest-queue"

    def begin(self, signals):  # lanes, movements, phases of every signal, once per episode
        self.serves = [s.phase_lanes for s in signals]

    def act(self, obs):  # obs.lanes: float32 [signals, lanes, 5]; obs.phase, obs.phase_mask, obs.lane_mask
        return [int((m * o[:, 0]).sum(1).argmax()) for m, o in zip(self.serves, obs.lanes)]


scenario = sys.argv[1] if len(sys.argv) > 1 else "salt-lake-city"
size = len(tf.family(scenario))
result = tf.evaluate(Longest(), scenario, budget=min(20, size), eval_seeds=5,
                     against=["actuated", "fixed-time"], out="results/longest")  # fmt: skip
print(result.table())
print(result.scores())
print(result.report())
