#!/usr/bin/env python3
"""Writes crates/learners/tests/data/sb3-updates.json: one update of each algorithm by Stable-Baselines3 and sb3-contrib.

    python3 -m venv /tmp/sb3 && /tmp/sb3/bin/pip install stable-baselines3==2.9.2 sb3-contrib==2.9.2
    /tmp/sb3/bin/python scripts/sb3_updates.py

Each entry has parameters before, the batch, the random numbers, and parameters after. Parameters are in the order of this
repository: layer by layer, weights of shape [inputs, outputs], then biases; policy, value, logarithms of deviations.
The tests beside the algorithms (crates/learners/src/rl/sb3/) make the same update.
"""

import json
import pathlib
from types import SimpleNamespace

import gymnasium
import numpy as np
import torch
from sb3_contrib import ARS, TRPO
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.type_aliases import ReplayBufferSamples, RolloutBufferSamples

OUT = pathlib.Path(__file__).parent.parent / "crates/learners/tests/data/sb3-updates.json"
WIDTH, ACTIONS, ROWS = 3, 2, 6
HIDDEN = [5, 5]


class Space(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(-10, 10, (WIDTH,), np.float32)
    action_space = gymnasium.spaces.Box(-1, 1, (ACTIONS,), np.float32)


class Numbered(Space):
    action_space = gymnasium.spaces.Discrete(ACTIONS)


def flat(*layers):
    """Layers side by side in a tuple are one layer."""
    out = []
    for layer in layers:
        layer = layer if isinstance(layer, tuple) else (layer,)
        out.append(torch.cat([part.weight for part in layer]).T.reshape(-1))
        out.append(torch.cat([part.bias for part in layer]))
    return [float(x) for x in torch.cat(out).detach()]


def linear(*networks):
    return [layer for network in networks for layer in network.modules() if isinstance(layer, torch.nn.Linear)]


def numbers(tensor):
    return [float(x) for x in tensor.detach().reshape(-1)]


def made(algorithm, env, **settings):
    torch.manual_seed(1)
    model = algorithm("MlpPolicy", env(), policy_kwargs={"net_arch": HIDDEN}, device="cpu", **settings)
    model.set_logger(Logger(None, []))
    with torch.no_grad():
        for parameter in model.policy.parameters():
            # Far from where they begin, so that every term of a gradient counts.
            parameter.add_(0.3 * torch.randn_like(parameter))
    return model


def replay():
    pair = [torch.randn(ROWS, WIDTH) for _ in range(2)]
    actions = torch.rand(ROWS, ACTIONS) * 2 - 1
    dones = torch.tensor([0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).reshape(-1, 1)
    return ReplayBufferSamples(pair[0], actions, pair[1], dones, torch.randn(ROWS, 1))


def replay_fields(batch):
    return {
        "states": numbers(batch.observations),
        "actions": numbers(batch.actions),
        "nexts": numbers(batch.next_observations),
        "rewards": numbers(batch.rewards),
        "follows": numbers(1 - batch.dones),
    }


def critics(model, which):
    return [flat(*linear(network)) for network in which.q_networks]


def sac():
    model = made(SAC, Space, batch_size=ROWS, buffer_size=10, learning_rate=0.01)
    model.critic_target.load_state_dict(model.critic.state_dict())
    with torch.no_grad():
        for parameter in model.critic_target.parameters():
            parameter.add_(0.1)
    batch, noise = replay(), [torch.randn(ROWS, ACTIONS) for _ in range(2)]
    model.replay_buffer = SimpleNamespace(sample=lambda *_, **__: batch)

    def state():
        policy = flat(*linear(model.actor.latent_pi), (model.actor.mu, model.actor.log_std))
        return {"policy": policy, "critics": critics(model, model.critic), "targets": critics(model, model.critic_target),
                "log_coefficient": float(model.log_ent_coef)}

    before, left = state(), list(noise)
    original = torch.distributions.normal._standard_normal
    torch.distributions.normal._standard_normal = lambda *_, **__: left.pop(0)
    model.train(1, ROWS)
    torch.distributions.normal._standard_normal = original
    return {**replay_fields(batch), "now": numbers(noise[0]), "after": numbers(noise[1]), "before": before, "then": state()}


def td3():
    model = made(TD3, Space, batch_size=ROWS, buffer_size=10, learning_rate=0.01, policy_delay=1)
    model.actor_target.load_state_dict(model.actor.state_dict())
    model.critic_target.load_state_dict(model.critic.state_dict())
    with torch.no_grad():
        for parameter in [*model.critic_target.parameters(), *model.actor_target.parameters()]:
            parameter.add_(0.1)
    batch, noise = replay(), torch.randn(ROWS, ACTIONS) * 3
    model.replay_buffer = SimpleNamespace(sample=lambda *_, **__: batch)

    def state():
        return {"policy": flat(*linear(model.actor)), "policy_target": flat(*linear(model.actor_target)),
                "critics": critics(model, model.critic), "targets": critics(model, model.critic_target)}

    before = state()
    original = torch.Tensor.normal_
    torch.Tensor.normal_ = lambda self, mean, deviation: self.copy_(noise * deviation)
    model.train(1, ROWS)
    torch.Tensor.normal_ = original
    return {**replay_fields(batch), "noise": numbers(noise), "before": before, "then": state()}


def on_policy(algorithm, env, **settings):
    model = made(algorithm, env, learning_rate=0.01, batch_size=ROWS, n_steps=ROWS, **settings)
    policy = model.policy
    states = torch.randn(ROWS, WIDTH)
    with torch.no_grad():
        distribution = policy.get_distribution(states)
        actions = distribution.sample()
        logs = distribution.log_prob(actions)
        # As if other policies had played, for PPO; what TRPO learns from its own policy played.
        if algorithm is PPO:
            logs = logs + torch.tensor([0.0, 0.5, -0.5, 0.1, -0.1, 0.3])
    advantages, returns = torch.randn(ROWS), torch.randn(ROWS)
    batch = RolloutBufferSamples(states, actions, torch.zeros(ROWS), logs, advantages, returns)
    model.rollout_buffer = SimpleNamespace(
        get=lambda _=None, batch_size=None: iter([batch]), values=np.zeros(ROWS), returns=np.zeros(ROWS)
    )

    def state():
        out = flat(*linear(policy.mlp_extractor.policy_net), policy.action_net)
        out += flat(*linear(policy.mlp_extractor.value_net), policy.value_net)
        return out + (numbers(policy.log_std) if hasattr(policy, "log_std") else [])

    before = state()
    randn_like = torch.randn_like
    torch.randn_like = torch.zeros_like
    model.train()
    torch.randn_like = randn_like
    return {
        "states": numbers(states), "actions": numbers(actions), "logs": numbers(logs), "advantages": numbers(advantages),
        "returns": numbers(returns), "before": before, "then": state(),
    }


def ars():
    torch.manual_seed(1)
    model = ARS("LinearPolicy", Space(), n_delta=4, n_top=3, device="cpu")
    model.set_logger(Logger(None, []))
    directions, returns = torch.randn(4, WIDTH * ACTIONS), torch.randn(8)
    normal = torch.normal
    torch.normal = lambda **_: directions
    model.evaluate_candidates = lambda *_: returns
    model._do_one_update(None, None)
    torch.normal = normal
    return {"directions": numbers(directions), "returns": numbers(returns), "then": numbers(model.weights)}


def main():
    on = {"ppo": (PPO, {"n_epochs": 1, "ent_coef": 0.2, "max_grad_norm": 0.3}), "trpo": (TRPO, {"n_critic_updates": 2})}
    updates = {"sac": sac(), "td3": td3(), "ars": ars()}
    for name, (algorithm, settings) in on.items():
        updates[f"{name}-continuous"] = on_policy(algorithm, Space, **settings)
        updates[f"{name}-numbered"] = on_policy(algorithm, Numbered, **settings)

    def short(value):
        if isinstance(value, dict):
            return {key: short(inner) for key, inner in value.items()}
        if isinstance(value, list):
            return [short(inner) for inner in value]
        return float(f"{value:.8g}")

    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text("{\n" + ",\n".join(f'"{k}": {json.dumps(short(v))}' for k, v in updates.items()) + "\n}\n")


if __name__ == "__main__":
    main()
