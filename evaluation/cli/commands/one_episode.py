"""The options of commands that fly one episode."""

from __future__ import annotations

from typing import Annotated, Any

from indoor_explorers.evaluation.harness.experiment.request import (
    NO_SETTINGS,
    RESOLUTION,
    SEED,
    TEAM,
    ComparisonRequest,
    Option,
    Request,
    Settings,
)


class EpisodeOptions(Request):
    """The policy and the task of one episode."""

    policy: Annotated[Any, Option(metavar="NAME")]
    """The policy: a name, NAME:PATH such as sb3:DIR, or module:Class, with parameters as in 'pso(length=1)'."""
    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """The scenario (default thesis-obstacles)."""
    maps: Annotated[str | None, Option(metavar="PATH")] = None
    """A map file to explore instead."""
    resolution: Annotated[float | None, RESOLUTION] = None
    """Metres per cell to resample the map file to. Pictures have no scale: a pixel of theirs counts as 1 m."""
    team: Annotated[int | None, TEAM] = None
    """Number of UAVs."""
    seed: Annotated[int, SEED] = 0
    """Seed of the episode; compare flies the same episode for the same seed."""
    settings: Settings = NO_SETTINGS
    """Scenario settings such as goal=0.9 or radio.range=3."""

    def comparison(self, policies: tuple[str, ...]) -> ComparisonRequest:
        """Return the request of a comparison of this one episode."""
        return ComparisonRequest(
            policies=policies,
            scenario=self.scenario,
            maps=self.maps,
            resolution=self.resolution,
            team=self.team,
            episodes=1,
            seed=self.seed,
            settings=self.settings,
        )
