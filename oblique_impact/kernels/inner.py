"""Lower helpers to LLVM IR only: the kernel that calls them compiles everything once.

numba optimizes each function with all that it calls and makes machine code of it, and then does so again for its
callers, up to the kernel.  For functions that nobody else calls all but the last is in vain, and it was half of
the time that compiling took.
"""

from __future__ import annotations

from typing import Any

from numba import _dynfunc
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering


class InnerLibrary(JITCodeLibrary):
    """The code of an inner function before optimization."""

    def finalize(self) -> None:
        """Close the library: nothing is added any more."""
        self._finalize_dynamic_globals()
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return the code with that of all functions which are called from it, each once.

        LLVM drops a function that nothing calls yet, so callers come first.
        """
        libraries: dict[CPUCodeLibrary, None] = {}
        self._collect(libraries)
        whole = super()._get_module_for_linking().clone()
        for library in reversed(libraries):
            if library is not self:
                whole.link_in(CPUCodeLibrary._get_module_for_linking(library), preserve=True)
        return whole

    def _collect(self, libraries: dict[CPUCodeLibrary, None]) -> None:
        """Add the libraries of all that is called, then this one."""
        for library in self._linking_libraries:
            if library not in libraries:
                if isinstance(library, InnerLibrary):
                    library._collect(libraries)
                else:
                    libraries[library] = None
        libraries[self] = None


@register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(NativeLowering):
    """The usual lowering, which keeps what callers need to find the function."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        state.flags.no_compile = state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        super().run_pass(state)
        lowered = state["cr"]
        description = lowered.fndesc
        # callers find a function by an object of its own, which runs nothing here
        callee = _dynfunc.make_function(
            description.lookup_module(), description.qualname, "", 0, lowered.env, (state.library,)
        )
        state.targetctx.insert_user_function(callee, description, [state.library])
        state["cr"] = lowered._replace(cfunc=callee)
        return True


class InnerCompiler(CompilerBase):
    """The compiler's usual passes with an :class:`InnerLibrary`."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes."""
        state = self.state
        state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        pipeline = DefaultPassBuilder.define_nopython_pipeline(state)
        pipeline.passes = [
            (_InnerLowering, words) if kind is NativeLowering else (kind, words) for kind, words in pipeline.passes
        ]
        return [pipeline]


#: of inner functions; they allocate nothing, and the arrays that come to them are owned by the caller of the
# kernel, so that nothing counts references to them
OPTIONS: dict[str, Any] = {"pipeline_class": InnerCompiler, "_nrt": False}
