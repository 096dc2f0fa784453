"""RESCO's own max-pressure agent: its code as it is, from a checkout of RESCO on PYTHONPATH.

    PYTHONPATH=RESCO tsc-family run --sumocfg ingolstadt1.sumocfg --methods max-pressure-resco \
        --controller resco-agent=resco_max_pressure.py:RescoMaxPressure --out results/resco-agent
"""

import numpy as np
import tsc_family as tf
from resco_benchmark.agents.maxpressure import MaxAgent


class RescoMaxPressure(tf.Controller):
    """RESCO's agent MAXPRESSURE."""

    name = "resco-agent"

    def begin(self, signals):
        # RESCO knows a phase by two of its numbered movements; a phase of one movement gets an empty one beside it.
        self.signals, self.empty = signals, 1 + max(m.index for s in signals for m in s.movements)
        pairs = [[[s.movements[m].index for m in p.pair] + [self.empty] for p in s.phases] for s in signals]
        self.agents = [MaxAgent(of_phases) for of_phases in pairs]

    def act(self, obs):
        phases = []
        for s, agent, phase, lanes, ahead in zip(self.signals, self.agents, obs.phase, obs.lanes, obs.downstream_queue):
            pressure = np.zeros(self.empty + 1)
            for m in s.movements:
                pressure[m.index] = lanes[m.lanes, 0].sum() - ahead[m.downstream].sum()
            phases += agent.act([[phase, *pressure]])
        return phases
