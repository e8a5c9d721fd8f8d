// How the browser draws in three dimensions.

/** How the browser draws in three dimensions, if at all. */
function drawing(): 'none' | 'processor' | 'graphics card' {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return 'none';
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '');
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /SwiftShader|llvmpipe|software/i.test(name) ? 'processor' : 'graphics card';
}

const DRAWING = drawing();
export const canDraw = (): boolean => DRAWING !== 'none';
/** Smooth edges cost a processor four times the work. */
export const SMOOTH = DRAWING === 'graphics card';
