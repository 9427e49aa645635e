"""Fly published code in a process of its own, and record what its network saw and answered; imports nothing of ours.

    python peer_flights.py ariadne|ir2|marvel CLONE OUT.npz STATES

Run it in an empty folder, with a Python of the clone's requirements: numpy below 2, torch, scikit-image, scikit-learn,
matplotlib, imageio. The maps are rooms by :func:`draw_maps`, and the weights random ones by :func:`random_weights`,
which are also saved beside OUT.npz, in the format of the clone's checkpoint.
"""

# mypy: ignore-errors

import sys
import types
from pathlib import Path

import numpy as np
import torch


def random_weights(shapes, seed=20261125):
    """Return weights by name, drawn in the order of the names: N(0, s^2 / inputs), plus 1 for scales of normalisation.

    With s = 0.6, 6 in the first layer, 0.15 in the pointer and 1.2 in MARVEL's layers, scores differ from node to node,
    and rounding in single precision does not count.
    """
    rng = np.random.default_rng(seed)
    found = {}
    for name in sorted(shapes):
        first, _, _ = name.partition(".")
        scale = {"initial_embedding": 6.0, "pointer": 0.15, "encoder": 0.6, "decoder": 0.6, "current_embedding": 0.6}
        values = rng.normal(size=tuple(shapes[name])) * scale.get(first, 1.2) / np.sqrt(max(shapes[name][-1], 16))
        found[name] = (values + ("normalizer.weight" in name)).astype(np.float32)
    return found


def with_random_weights(network, out):
    state = network.state_dict()
    drawn = random_weights({name: value.shape for name, value in state.items()})
    network.load_state_dict({name: torch.from_numpy(value) for name, value in drawn.items()})
    torch.save({"policy_model": network.state_dict(), "episode": 7}, out.with_suffix(".pth"))
    return network.eval()


def draw_maps(folder, shape, colours, side=190, wall=10, door=60, count=3):
    """Write maps of rooms with a door in every wall between two, each with a start of 16 x 16 pixels in the middle."""
    from skimage.io import imsave  # type: ignore

    Path(folder).mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(5)
    for k in range(count):
        free = np.zeros(shape, np.uint8)
        rows, cols = (range(wall, size - side, side + wall) for size in shape)
        for r in rows:
            for c in cols:
                free[r : r + side, c : c + side] = 255
                along = int(rng.integers(20, side - door - 20))
                if r + side + wall in rows:
                    free[r + side : r + side + wall, c + along : c + along + door] = 255
                if c + side + wall in cols:
                    free[r + along : r + along + door, c + side : c + side + wall] = 255
        middle = rows[len(rows) // 2] + 90, cols[len(cols) // 2] + 90
        free[middle[0] : middle[0] + 16, middle[1] : middle[1] + 16] = 208
        picture = np.repeat(free[:, :, None], 3, axis=2) if colours else free
        imsave(f"{folder}/{k}.png", picture, check_contrast=False)


class Record:
    """The recorded arrays, by names that number the states."""

    def __init__(self, clone, out, states):
        self.clone, self.out, self.states, self.count, self.arrays = clone, out, states, 0, {}

    def add(self, **arrays):
        for name, value in arrays.items():
            value = value.detach().numpy() if isinstance(value, torch.Tensor) else np.asarray(value)
            self.arrays[f"{self.count}/{name}"] = value
        self.count += 1
        if self.count >= self.states:
            np.savez_compressed(self.out, **self.arrays)
            sys.exit()


def attended(mask):
    """Return the nodes that each node attends to, (N, K), -1 for none."""
    near = [np.flatnonzero(row == 0) for row in mask[0].numpy()]
    padded = np.full((len(near), max(map(len, near))), -1, np.int16)
    for row, each in zip(padded, near, strict=True):
        row[: len(each)] = each
    return padded


def lattice_inputs(observation, logits):
    nodes, edges, own, _, masked, mask = observation
    return {
        "features": nodes[0],
        "near": attended(mask),
        "own": own[0, 0, 0],
        "options": edges[0, 0],
        "masked": masked[0, 0],
        "logits": logits[0],
    }


class Comparable(np.ndarray):
    """An array that is unequal to every list, as arrays were before numpy 1.25: ARiADNE's node.py relies on it."""

    def __ne__(self, other):
        return True if isinstance(other, list) else np.ndarray.__ne__(self, other)


def ariadne(record, rng):
    draw_maps("DungeonMaps/test", (480, 640), colours=True)
    import node  # type: ignore
    from env import Env  # noqa: TID251  # the clone's
    from model import PolicyNet  # type: ignore
    from test_worker import TestWorker  # type: ignore

    update = node.Node.update_observable_frontiers
    node.Node.update_observable_frontiers = lambda self, seen, new, belief: update(
        self, seen.view(Comparable), new.view(Comparable), belief
    )
    network = with_random_weights(PolicyNet(4, 128), record.out)
    for episode in range(1000):
        worker = TestWorker.__new__(TestWorker)
        worker.device, worker.greedy, worker.k_size, worker.local_policy_net = "cpu", True, 20, network
        worker.env = Env(map_index=episode, k_size=20, test=True)
        worker.robot_position, travelled = worker.env.start_position, 0
        for step in range(40):
            seen = worker.get_observations()
            with torch.no_grad():
                logits = network(*seen)
            inputs = lattice_inputs(seen, logits)
            env = worker.env
            record.add(
                **inputs,
                belief=env.robot_belief.astype(np.uint8),
                cell=worker.robot_position,
                cells=env.node_coords,
                first=step == 0,
                chosen=worker.select_node(seen)[0],
            )
            legal = np.flatnonzero(inputs["masked"].numpy() == 0)
            if not len(legal):
                break
            there = env.node_coords[int(inputs["options"][rng.choice(legal)])]
            _, done, worker.robot_position, travelled = env.step(worker.robot_position, there, travelled)
            if done:
                break


def ir2(record, rng):
    draw_maps("DungeonMaps/test/complex", (1000, 1000), colours=False)
    text = Path(record.clone, "test_parameter.py").read_text().replace('= "hybrid"', '= "complex"', 1)
    test_parameter = sys.modules["test_parameter"] = types.ModuleType("test_parameter")
    exec(text, vars(test_parameter))  # the maps of the weights' training, where nodes have the distance of ours
    from env import Env  # noqa: TID251  # likewise
    from model import PolicyNet  # type: ignore
    from robot import Robot  # type: ignore
    from test_multi_robot_worker import TestWorker  # type: ignore

    network = with_random_weights(PolicyNet(6, 128), record.out)
    for episode in range(1000):
        worker = TestWorker.__new__(TestWorker)
        worker.device, worker.greedy, worker.k_size, worker.node_padding_size = (
            "cpu",
            True,
            test_parameter.K_SIZE,
            99999,
        )
        worker.n_agent, worker.local_policy_net, worker.global_step = 4, network, episode
        worker.env = env = Env(map_index=episode, n_agent=4, k_size=worker.k_size)
        worker.robot_list = [Robot(i, env.all_node_coords[i][i]) for i in range(4)]
        worker.all_robot_positions = [robot.robot_position for robot in worker.robot_list]
        fly_ir2(worker, record, rng)


def fly_ir2(worker, record, rng):
    """Fly 25 moves of each robot; from the third on, each chooses as if it had been out of contact from the start."""
    env, team = worker.env, range(worker.n_agent)
    first = [env.all_robot_belief[i][i].copy() for i in team]
    for step in range(25):
        for i, robot in enumerate(worker.robot_list):
            if not env.update_graph(i, env.find_frontier(env.all_downsampled_belief[i]), eps=0, step=step):
                return
            others = [j for j in team if j != i]
            if step > 1:
                env.group_ids_list = [[i], others]
                env.all_robot_belief[i] = [env.all_robot_belief[i][i] if j == i else first[j] for j in team]
            seen, fine = worker.get_observations(robot.robot_position, i, 0, step)
            if not fine:
                return
            with torch.no_grad():
                logits = worker.local_policy_net(*seen)
            inputs = lattice_inputs(seen, logits)
            known = env.all_robot_positions_belief[i]
            located = [j for j in others if known[j] is not None]  # IR2 forgets mates that are not where they should be
            record.add(
                **inputs,
                belief=env.all_robot_belief[i][i].astype(np.uint8),
                cell=robot.robot_position,
                cells=env.all_node_coords[i],
                agent=i,
                step=step,
                mates=[known[j] for j in located],
                lacking=[env.all_robot_map_belief_area_diff[i][j] if step > 1 else 0.0 for j in located],
                heard=[cell for j in others for part in env.all_robot_global_graph_belief[i][j] for cell in part],
            )
            legal = np.flatnonzero((inputs["masked"].numpy() == 0) & (np.arange(worker.k_size) > 0))
            chosen = int(inputs["options"][rng.choice(legal)]) if len(legal) else int(seen[2])
            there = env.all_node_coords[i][chosen]
            far = np.linalg.norm(there - robot.robot_position)
            robot.robot_position = there
            worker.all_robot_positions[i] = env.all_robot_positions_belief[i][i] = there
            if not env.single_robot_step(i, worker.all_robot_positions, 0, step, far)[0]:
                return


def marvel(record, rng):
    draw_maps("maps_test", (500, 500), colours=False)
    for name in ("shapely", "shapely.geometry"):  # used for pictures and training alone
        sys.modules.setdefault(name, types.SimpleNamespace(Point=None, Polygon=None))
    from utils.agent import Agent  # type: ignore
    from utils.env_test import Env  # type: ignore
    from utils.model import PolicyNet  # type: ignore
    from utils.node_manager import NodeManager  # type: ignore
    from utils.utils import get_cell_position_from_coords  # type: ignore

    network = with_random_weights(PolicyNet(6, 128, 36), record.out)
    for episode in range(1000):
        env = Env(episode % 3, 360, 2, 10)  # one robot fails in its constructor
        env.robot_locations = env.robot_locations[:1] * 0.0
        agent = Agent(0, network, 120, 270, 10, NodeManager(120, 10, 9.0), None)
        for step in range(30):
            agent.update_graph(env.belief_info, env.robot_locations[0].copy())
            agent.update_planning_state(env.robot_locations)
            seen = agent.get_observation(pad=False)
            with torch.no_grad():
                logits = network(*seen)
            options, masked = seen[4][0, :, 0], seen[5][0, 0]
            chosen = agent.select_next_waypoint(seen, greedy=True)[0]
            record.add(
                features=seen[0][0],
                near=attended(seen[2]),
                own=seen[3][0, 0, 0],
                options=options,
                masked=masked,
                frontiers=seen[6][0],
                visited=seen[7][0],
                headings=seen[8][0],
                logits=logits[0],
                chosen=chosen,
                belief=env.robot_belief.astype(np.uint8),
                cell=get_cell_position_from_coords(agent.location, env.belief_info),
                cells=get_cell_position_from_coords(agent.node_coords, env.belief_info).reshape(-1, 2),
                way=get_cell_position_from_coords(np.array(agent.path_coords), env.belief_info).reshape(-1, 2),
                first=step == 0,
            )
            legal = np.flatnonzero(masked.numpy() == 0)
            if not len(legal):
                break
            there = agent.node_coords[int(options[rng.choice(legal)])]
            env.robot_locations[0] = there
            env.update_robot_belief(get_cell_position_from_coords(there, env.belief_info), 0)


if __name__ == "__main__":
    kind, clone, out, states = sys.argv[1:]
    sys.path.insert(0, clone)
    sys.path.insert(0, str(Path.cwd()))
    np.random.seed(1)  # noqa: NPY002  # what the clones draw from
    torch.set_num_threads(1)
    {"ariadne": ariadne, "ir2": ir2, "marvel": marvel}[kind](
        Record(clone, Path(out), int(states)), np.random.default_rng(1)
    )
