"""Lower helpers to LLVM IR only: the kernel that calls them compiles everything once.

numba optimizes each function with all that it calls and makes machine code of it, and then does so again for its
callers, up to the kernel.  For functions that nobody else calls all but the last is in vain, and it was half of
the time that compiling took.
"""

from __future__ import annotations

from typing import Any

from numba import _dynfunc
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler, CompilerBase, DefaultPassBuilder, Flags
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


class _CalleeFlags(Flags):
    """The options that callees inherit, the same for all callers.

    numba keeps what it has compiled by the types of arguments and by these options.  With those of each caller a
    function would be compiled again for each kind of caller, and hashing them takes a tenth of the time.
    """

    __hash__ = object.__hash__
    __eq__ = object.__eq__


_callee_flags = _CalleeFlags()


class _CallerFlags(Flags):
    """The options of a function, of which callees are shown a copy."""

    def copy(self) -> _CalleeFlags:
        """Return the options that callees inherit."""
        if not _callee_flags.is_set("error_model"):
            _callee_flags.error_model, _callee_flags.fastmath = self.error_model, self.fastmath
            _callee_flags.forceinline = _callee_flags.nrt = False
        return _callee_flags


class KernelCompiler(Compiler):
    """The compiler's usual passes for a kernel, which shares its callees with inner functions."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = _CallerFlags(self.state.flags)


#: passes for what numeric source does without: closures, generators, `with`, expressions of whole arrays, reports
_NEEDLESS = {
    *("WithLifting", "InlineClosureLikes", "MakeFunctionToJitFunction", "InlineInlinables", "InlineOverloads"),
    *("FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass", "RewriteDynamicRaises"),
    *("NopythonRewrites", "NoPythonSupportedFeatureValidation", "AnnotateTypes", "DumpParforDiagnostics"),
}


class InnerCompiler(CompilerBase):
    """The compiler's usual passes but for needless ones, with an :class:`InnerLibrary`."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.state.flags = _CallerFlags(self.state.flags)

    def define_pipelines(self) -> list[Any]:
        """Return the passes."""
        state = self.state
        state.library = InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        pipeline = DefaultPassBuilder.define_nopython_pipeline(state)
        pipeline.passes = [
            (_InnerLowering, words) if kind is NativeLowering else (kind, words)
            for kind, words in pipeline.passes
            if kind.__name__ not in _NEEDLESS
        ]
        pipeline._ENFORCING = False  # it would look for the lives of variables again after every pass
        return [pipeline]


#: of inner functions; they allocate nothing, and the arrays that come to them are owned by the caller of the
# kernel, so that nothing counts references to them
OPTIONS: dict[str, Any] = {"pipeline_class": InnerCompiler, "_nrt": False}
