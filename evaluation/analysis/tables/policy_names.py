"""Names of policies in tables of text, with marks and footnotes for privileged, checked and exposed policies."""

from __future__ import annotations

from collections.abc import Iterable

from indoor_explorers.evaluation.harness.results.results import Results

#: Marks policies that read the settings of the maps' generator.
DAGGER = "\N{DAGGER}"
#: Marks policies that failed a check for hidden knowledge.
DOUBLE_DAGGER = "\N{DOUBLE DAGGER}"
#: Marks policies from outside this package that were not isolated.
SECTION = "\N{SECTION SIGN}"
#: Follows a decision time that is a share of a batch's.
BATCH_SHARE = "batch share"

#: What such a policy could have done.
EXPOSED = "flew in the process that has the true map, where it could have read it"


def marked(results: Results, policy: str) -> str:
    """Return the name of a policy, marked for privileged knowledge, a failed check and missing isolation."""
    marks = [
        *(["(knows the map)"] if policy in results.privileged_policies else []),
        *([DAGGER] if policy in results.generator_policies else []),
        *([DOUBLE_DAGGER] if policy in results.failed_checks else []),
        *([SECTION] if policy in results.exposed_policies else []),
    ]
    return " ".join([policy, *marks])


def footnotes(results: Results, policies: Iterable[str], *, times: bool = True) -> list[str]:
    """Return a sentence for each mark of these policies; ``times`` says whether decision times are shown."""
    shown, notes = set(policies), []
    if shown.intersection(results.generator_policies):
        notes.append(f"{DAGGER} reads the settings of the maps' generator, never the map.")
    notes += [
        f"{DOUBLE_DAGGER} {name} failed the check {text}."
        for name, text in results.failed_checks.items()
        if name in shown
    ]
    if shown.intersection(results.exposed_policies):
        notes.append(f"{SECTION} {EXPOSED}.")
    if times and shown.intersection(results.batched_policies):
        what = "the policy decides for many UAVs at once, and each one's time is its share of the whole"
        notes.append(f"{BATCH_SHARE.capitalize()}: {what}.")
    return notes
