"""A DQN of Stable-Baselines3, trained on every point MDP and ranked beside tsc-family's methods.

In a clone ``pip install './python[sumo,gymnasium]' stable-baselines3``, then ``python sb3_dqn.py [SCENARIO] [BUDGET] [EPISODES]``.
"""

import sys

import torch
from stable_baselines3 import DQN
from stable_baselines3.common.callbacks import BaseCallback

import tsc_family as tf


class StableDqn(tf.Controller):
    """Stable-Baselines3's DQN on what IDQN sees."""

    name = "sb3-dqn"

    def train(self, env):
        # Workers share the processors.
        torch.set_num_threads(1)
        gym = env.gym(observation="idqn", reward="wait")
        decisions = env.decisions
        self.model = DQN(
            "MlpPolicy", gym, seed=self.seed % 2**32, learning_rate=5e-4, buffer_size=50_000, learning_starts=decisions,
            batch_size=64, train_freq=1, target_update_interval=500, exploration_fraction=0.6, device="cpu",
        )  # fmt: skip
        self.model.learn(env.episodes * decisions, callback=Log(env))

    def act(self, obs):
        # What the environment of the training shows, for the one signal.
        return [int(self.model.predict(obs.idqn(), deterministic=True)[0])]

    def save(self, path):
        self.model.save(path)

    def load(self, path):
        self.model = DQN.load(path, device="cpu")


class Log(BaseCallback):
    """Puts the loss into the rows of the training."""

    def __init__(self, env):
        super().__init__()
        self.env = env

    def _on_step(self):
        loss = self.model.logger.name_to_value.get("train/loss")
        if loss is not None:
            self.env.log(loss=loss)
        return True


scenario, budget, episodes = (sys.argv[1:] + ["salt-lake-city", "8", "60"][len(sys.argv) - 1 :])[:3]
result = tf.evaluate(StableDqn(), scenario, budget=int(budget), episodes=int(episodes), eval_seeds=5,
                     against=["max-pressure", "actuated", "fixed-time", "idqn"], out="results/sb3")  # fmt: skip
print(result.table())
print(result.report())
