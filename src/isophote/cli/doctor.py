"""`isophote doctor`: what this machine can do, and whether all is well."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from isophote.cli.messages import log, print_facts, print_json

__all__ = ["EXAMPLES", "doctor"]

EXAMPLES = """\b
Examples:
  isophote doctor
  isophote doctor --json
  isophote doctor --clean

Kernels are compiled once and kept in a cache. ISOPHOTE_CACHE_DIR names another folder for it. The exit status is 1
where a check fails.
"""


def doctor(
    clean: Annotated[
        bool, typer.Option("--clean", help="Remove compiled kernels of other versions from the cache.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Check this machine, and make a test picture."""
    from isophote.cli.machine import cache_facts, clean_cache, machine_facts
    from isophote.cli.self_test import check_exr, check_render

    removed = clean_cache() if clean else None
    # The picture goes first, since it compiles what the cache is asked for.
    checks = {"render": check_render(), "openexr": check_exr()}
    facts = {**machine_facts(), "cache": {**cache_facts(), "removed": removed}, "checks": checks}
    if as_json:
        print_json(facts)
    else:
        print_facts(_lines(facts))
    failed = [name for name, result in facts["checks"].items() if not result["ok"]]
    if failed:
        log(f"error: failed: {', '.join(failed)}")
        raise typer.Exit(1)


def _lines(facts: dict[str, Any]) -> dict[str, str]:
    cache = facts["cache"]
    lines = {
        "isophote": facts["isophote"],
        "Python": f"{facts['python']} ({facts['executable']})",
        "NumPy": facts["numpy"],
        "Numba": f"{facts['numba']}, LLVM {facts['llvm']}",
        "processor": f"{facts['cpu']}; {', '.join(facts['features']) or 'no AVX'}",
        "processors": str(facts["processors"]),
        "cache": f"{cache['folder']}\n{_cache_text(cache)}",
    }
    for name, result in facts["checks"].items():
        lines[f"{name} check"] = f"{'ok' if result['ok'] else 'failed'}: {result['detail']}"
    return lines


def _cache_text(cache: dict[str, Any]) -> str:
    text = f"kernels are {'' if cache['compiled'] else 'not '}compiled; {_megabytes(cache['bytes'])}"
    if not cache["writable"]:
        text += "\nnot writable, so kernels are compiled anew in every run; name another in ISOPHOTE_CACHE_DIR"
    if cache["removed"] is not None:
        text += f"\nfolders of other versions removed: {len(cache['removed'])}"
    if cache["stale_folders"]:
        stale = f"{cache['stale_folders']}, {_megabytes(cache['stale_bytes'])}"
        text += f"\nfolders of other versions: {stale}; --clean removes them"
    return text


def _megabytes(count: int) -> str:
    return f"{count / 1e6:.1f} MB"
