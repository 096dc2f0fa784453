"""RESCO's max pressure as a class: the phase whose named movements have the longest queues, less those ahead."""

import numpy as np
import tsc_family as tf


class MaxPressure(tf.Controller):
    """The phase whose two main movements have the longest queues (RESCO's rule)."""

    name = "pressure-python"

    def begin(self, signals):
        # Per signal a row per phase: how often each lane counts, and each lane ahead.
        self.upstream, self.downstream = [], []
        for s in signals:
            lanes = np.zeros((len(s.phases), s.phase_lanes.shape[1]), np.float32)
            ahead = np.zeros((len(s.phases), 1 + max((d for m in s.movements for d in m.downstream), default=-1)))
            for p, phase in enumerate(s.phases):
                for m in phase.pair:
                    np.add.at(lanes[p], s.movements[m].lanes, 1)
                    np.add.at(ahead[p], s.movements[m].downstream, 1)
            self.upstream.append(lanes)
            self.downstream.append(ahead)

    def act(self, obs):
        queues = obs.lanes[:, :, 0]
        ahead = obs.downstream_queue
        return [
            int((up @ queues[i] - down @ ahead[i, : down.shape[1]]).argmax())
            for i, (up, down) in enumerate(zip(self.upstream, self.downstream))
        ]
