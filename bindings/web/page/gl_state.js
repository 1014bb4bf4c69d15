// Answers Dear ImGui's questions about WebGL's state. The browser itself would answer them only after everything before
// was drawn.

const { VIEWPORT, SCISSOR_BOX, BLEND_SRC_RGB, BLEND_DST_RGB, BLEND_SRC_ALPHA, BLEND_DST_ALPHA, BLEND_EQUATION_RGB,
  BLEND_EQUATION_ALPHA } = WebGL2RenderingContext;

// What the calls set.
const setBy = {
  viewport: (...box) => [[VIEWPORT, Int32Array.from(box)]],
  scissor: (...box) => [[SCISSOR_BOX, Int32Array.from(box)]],
  blendFunc: (from, to) => setBy.blendFuncSeparate(from, to, from, to),
  blendFuncSeparate: (...factors) =>
    [BLEND_SRC_RGB, BLEND_DST_RGB, BLEND_SRC_ALPHA, BLEND_DST_ALPHA].map((name, i) => [name, factors[i]]),
  blendEquation: (mode) => setBy.blendEquationSeparate(mode, mode),
  blendEquationSeparate: (rgb, alpha) => [[BLEND_EQUATION_RGB, rgb], [BLEND_EQUATION_ALPHA, alpha]],
};

export function rememberState(gl) {
  const known = new Map();
  for (const [name, changes] of Object.entries(setBy)) {
    const call = gl[name];
    gl[name] = (...values) => {
      call.apply(gl, values);
      for (const [parameter, value] of changes(...values)) known.set(parameter, value);
    };
  }
  const ask = gl.getParameter;
  gl.getParameter = (parameter) => known.get(parameter) ?? ask.call(gl, parameter);
}
