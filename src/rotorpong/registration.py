"""Names of the Gymnasium environments, told to Gymnasium as soon as it is there.

Gymnasium is heavy and most of rotorpong does without it, its command line above all; and since
version 1.0 it asks nobody for plugins. So `import rotorpong` does not import it: where it is
imported already, the environments are registered at once, else right after it was, by a finder
that waits in `sys.meta_path` and then goes away. What an environment needs is loaded when one is
made.
"""

import sys
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

_FOLDER = "rotorpong.lab.environments"


def register_environments() -> None:
    """Register all environments: now, or when gymnasium is imported."""
    if "gymnasium" in sys.modules:
        _register()
    elif _WAITING not in sys.meta_path:
        sys.meta_path.insert(0, _WAITING)


def _register() -> None:
    from gymnasium.envs.registration import register

    register(
        id="rotorpong/Intercept-v0",
        entry_point=f"{_FOLDER}.intercept:InterceptEnv",
        vector_entry_point=f"{_FOLDER}.intercept_vector:InterceptVectorEnv",
    )
    register(
        id="rotorpong/InterceptVision-v0",
        entry_point=f"{_FOLDER}.intercept_vision:InterceptVisionEnv",
    )
    register(
        id="rotorpong/Primitive-v0",
        entry_point=f"{_FOLDER}.primitive:PrimitiveEnv",
    )


class _Waiting:
    """Finds gymnasium as the others do, and lets its loader register afterwards."""

    def find_spec(
        self, name: str, path: Any, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if name != "gymnasium":  # path may be a namespace package's, which is no Sequence
            return None
        others = (finder for finder in sys.meta_path if finder is not self)
        found = (finder.find_spec(name, path, target) for finder in others)
        spec = next((spec for spec in found if spec is not None), None)
        if spec is not None and spec.loader is not None:
            self._register_after(spec.loader)
        return spec

    def _register_after(self, loader: Any) -> None:
        load = loader.exec_module

        def load_and_register(module: ModuleType) -> None:
            load(module)
            if self in sys.meta_path:
                sys.meta_path.remove(self)
                _register()

        loader.exec_module = load_and_register


_WAITING = _Waiting()
