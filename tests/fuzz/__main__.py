"""`python -m fuzz`: many hostile files, with a table of what came of them. See `make fuzz`."""

import argparse
import sys
from collections import defaultdict
from pathlib import Path

from fuzz.harness import SPECIAL, Case, Harness, Result, cases, special_cases, temporary

HEAD = ("format", "cases", "read", "refused", "failed", "worst s", "worst MB")


def table(results: list[Result]) -> str:
    """One row per format, and the sum."""
    rows: dict[str, list[Result]] = defaultdict(list)
    for result in results:
        rows[result.case.seed.name].append(result)
    lines = [f"{HEAD[0]:34}" + "".join(f"{name:>10}" for name in HEAD[1:])]
    for name, found in (*rows.items(), ("all", results)):
        counts = [len(found), *(sum(r.outcome == kind for r in found) for kind in ("read", "refused"))]
        numbers = "".join(f"{n:10}" for n in (*counts, sum(r.failed for r in found)))
        worst = f"{max(r.seconds for r in found):10.2f}{max(r.mb for r in found):10}"
        lines.append(f"{name:34}{numbers}{worst}")
    return "\n".join(lines)


def told(result: Result) -> str:
    """A failure in one line, with how to repeat it."""
    case = result.case
    return f"{result.outcome}: {case.seed.name}, {result.mutation}: {result.message}\n    {case.again}"


def main() -> int:
    """Run the cases; 1 if any failed."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("--cases", type=int, default=5000, help="how many, in turn from every format")
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers")
    parser.add_argument("--only", help="the formats whose names begin so")
    parser.add_argument("--case", type=int, help="only the case of this number; prints its whole message")
    parser.add_argument("--special", choices=SPECIAL, help="only this in the place of a file")
    parser.add_argument("--keep", type=Path, help="folder for the files that failed, outside the repository")
    parser.add_argument("--files", type=Path, help="folder with other files to start from, up to 1 MB each")
    given = parser.parse_args()
    with temporary() as folder, Harness(Path(folder), given.keep, given.files) as harness:
        seeds = [s for s in harness.seeds if s.name.startswith(given.only or "")]
        if not seeds:
            parser.error("no such format; known: " + ", ".join(s.name for s in harness.seeds))
        if given.special is not None:
            chosen = [case for case in special_cases(seeds) if case.special == given.special]
        elif given.case is not None:
            chosen = [Case(seed, given.case, given.seed) for seed in seeds]
        else:
            chosen = [*cases(seeds, given.cases, given.seed), *special_cases(seeds)]
        results = []
        for case in chosen:
            results.append(harness.run(case))
            if results[-1].failed or len(chosen) <= len(seeds):
                print(told(results[-1]), flush=True)
    print(table(results))
    return int(any(r.failed for r in results))


if __name__ == "__main__":
    sys.exit(main())
