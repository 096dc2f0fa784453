"""Counts MPLight networks of RESCO's design that are dead after one training episode on a point MDP of Salt Lake City.

    pip install './python[sumo]' torch pfrl packaging
    python scripts/dead_networks.py L3-S30-D400-Q500-l0-r0 --seeds 300

The network is RESCO's in PyTorch with PyTorch's initial weights, and learning is pfrl's DQN with RESCO's settings for 100
episodes. Source: Pi-Star-Lab/RESCO, agents/mplight.py, agents/pfrl_dqn.py, config/agent_config.py. A network is dead where its
values differ between no two actions or no two states of the episode, as `is_alive` of crates/learners asks.
"""

import argparse
import random

import numpy as np
import torch
from pfrl.agents import DQN
from pfrl.explorers import LinearDecayEpsilonGreedy
from pfrl.q_functions import DiscreteActionValueHead
from pfrl.replay_buffers import ReplayBuffer
from torch import nn
from torch.nn import functional as f

import tsc_family  # noqa: F401  finds libsumo
from tsc_family._native import Simulation

EPISODES = 100


class Frap(nn.Module):
    """RESCO's network: values of phases, each a pair of movements, from the phase that is shown and the movements' pressures."""

    def __init__(self, pairs, movements):
        super().__init__()
        self.pairs = pairs
        others = [[b for b in pairs if b is not a] for a in pairs]
        self.shares = torch.tensor([[int(len({*a, *b}) == 3) for b in rest] for a, rest in zip(pairs, others)])
        self.served = torch.tensor([[int(m in pair) for m in range(movements)] for pair in pairs])
        self.served_embedding = nn.Embedding(2, 4)
        self.pressure_layer = nn.Linear(1, 4)
        self.movement_layer = nn.Linear(8, 16)
        self.pair_layer = nn.Conv2d(32, 20, 1)
        self.share_embedding = nn.Embedding(2, 4)
        self.share_layer = nn.Conv2d(4, 20, 1)
        self.competition_layer = nn.Conv2d(20, 20, 1)
        self.last_layer = nn.Conv2d(20, 1, 1)
        self.head = DiscreteActionValueHead()

    def values(self, states):
        served = torch.sigmoid(self.served_embedding(self.served[states[:, 0].long()]))
        pressures = torch.sigmoid(self.pressure_layer(states[:, 1:, None]))
        movements = f.relu(self.movement_layer(torch.cat((served, pressures), -1)))
        phases = [movements[:, a] + movements[:, b] for a, b in self.pairs]
        rows = [torch.stack([torch.cat((a, b), -1) for b in phases if b is not a], 1) for a in phases]
        competing = f.relu(self.pair_layer(torch.stack(rows, 1).permute(0, 3, 1, 2)))
        shares = f.relu(self.share_embedding(self.shares)).permute(2, 0, 1)[None]
        product = competing * f.relu(self.share_layer(shares))
        return self.last_layer(f.relu(self.competition_layer(product)))[:, 0].sum(-1)

    def forward(self, states):
        return self.head(self.values(states.float()))


def is_dead(network, states):
    with torch.no_grad():
        values = network.values(torch.tensor(np.stack(states))).numpy()

    def differs(row):
        return np.ptp(row) > 1e-6 * max(1.0, np.abs(row).max())

    return not (any(map(differs, values)) and any(map(differs, values.T)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("point")
    parser.add_argument("--seeds", type=int, default=300)
    args = parser.parse_args()
    torch.set_num_threads(1)
    simulation = Simulation(args.point, None, "salt-lake-city", [], None)
    signal = simulation.signals()[0]
    pairs = [tuple(phase.pair) for phase in signal.phases]
    dead = 0
    for seed in range(args.seeds):
        torch.manual_seed(seed)
        np.random.seed(seed)
        random.seed(seed)
        network = Frap(pairs, len(signal.movements))
        decay = int(0.8 * EPISODES) * simulation.decisions
        agent = DQN(
            network,
            torch.optim.Adam(network.parameters()),
            ReplayBuffer(10_000),
            0.99,
            LinearDecayEpsilonGreedy(1.0, 0.0, decay, lambda: np.random.randint(len(pairs))),
            minibatch_size=32,
            replay_start_size=32,
            phi=lambda state: np.asarray(state, dtype=np.float32),
            target_update_interval=500,
        )
        simulation.reset(1000 * seed)
        states, done = [simulation.mplight(0)], False
        while not done:
            done = simulation.step([int(agent.act(states[-1]))])
            states.append(simulation.mplight(0))
            agent.observe(states[-1], simulation.pressure(0), done, False)
        dead += is_dead(network, states)
        print(f"{dead} of {seed + 1} networks are dead after one episode", flush=True)


if __name__ == "__main__":
    main()
