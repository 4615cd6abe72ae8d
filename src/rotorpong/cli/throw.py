"""The command that shows one serve: throw."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotorpong.cli.common import Varied, compile_kernels, knowledge_of, named, progress_bar, say


@dataclass(frozen=True, kw_only=True)
class Throw(Varied):
    """Show one serve, onboard and from beside the table: a film, an animation or a sheet."""

    out: Path
    """FILE.mp4, FILE.gif, or FILE.png for a sheet of moments."""
    index: int = 0
    """Which serve: trial INDEX of `evaluate` with the same seed."""
    slow: float = 4.0
    """How many times slower than life, 1 to 100."""
    experience: Path | None = None
    """What a player that learns has learnt: a file of `train`; others do not use it. Default: ten
    scripted demonstrations."""

    def run(self) -> dict[str, Any]:
        """Throw, and write the pictures."""
        from rotorpong.lab.throw import check, throw

        check(self.index, self.out, self.slow)
        spec = self.spec(randomize=self.randomize)
        known = knowledge_of(spec, self.experience)
        compile_kernels(self.eyes)
        with progress_bar() as advance:
            result = throw(
                spec,
                self.index,
                self.out,
                slow=self.slow,
                knowledge=known,
                progress=named(advance, "pictures"),
            )
        if not self.json:
            say(f"{result['outcome'].replace('_', ' ')}: {result['frames']} pictures in {self.out}")
        return result
