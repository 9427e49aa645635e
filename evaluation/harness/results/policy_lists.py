"""The policies of a comparison by what is true of them."""

from __future__ import annotations

from typing import Any

#: How the classes of this package's own policies begin.
OURS = f"{__name__.partition('.')[0]}."


class PolicyLists:
    """Lists policies by their facts."""

    policies: dict[str, dict[str, Any]]
    """Facts of each policy by name, in table order."""

    @property
    def privileged_policies(self) -> list[str]:
        """The policies that are given the true map and are not ranked, in table order."""
        return [name for name, about in self.policies.items() if about.get("privileged")]

    @property
    def generator_policies(self) -> list[str]:
        """The policies that read the settings of the maps' generator, in table order."""
        return [name for name, about in self.policies.items() if about.get("uses_generator")]

    @property
    def aims(self) -> dict[str, list[str]]:
        """The policies by the coverage that they plan for, in table order; "not stated" where they do not say."""
        found: dict[str, list[str]] = {}
        for name, about in self.policies.items():
            found.setdefault(about.get("plans_for", "not stated"), []).append(name)
        return found

    @property
    def failed_checks(self) -> dict[str, str]:
        """The check for hidden knowledge that a policy failed and how to fix it, by the policy's name."""
        return {name: about["failed_check"] for name, about in self.policies.items() if about.get("failed_check")}

    @property
    def policies_from_outside(self) -> list[str]:
        """The policies from outside this package, in table order."""
        return [name for name, about in self.policies.items() if not str(about.get("class", OURS)).startswith(OURS)]

    @property
    def policies_of_unknown_code(self) -> list[str]:
        """The policies from outside this package without hashes of their sources, in table order."""
        return [name for name in self.policies_from_outside if not self.policies[name].get("sources")]

    @property
    def exposed_policies(self) -> list[str]:
        """The policies from outside this package that flew in the process that had the true map, in table order.

        Stores from before policies could be isolated do not say so of any.
        """
        return [name for name in self.policies_from_outside if self.policies[name].get("isolated") is False]

    @property
    def batched_policies(self) -> list[str]:
        """The policies that decide for many UAVs at once: their decision times are shares of a batch's."""
        return [name for name, about in self.policies.items() if about.get("batched")]
