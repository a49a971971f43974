// A light grid (tyndall bake --grid, tyndall export --for three) in a shader: GLSL ES 3.00, for WebGL2 with three.js or without.

/** Irradiance from bands 0 and 1 of the radiance around a point: A_0 Y_00 = sqrt(pi) / 2 and A_1 sqrt(3 / (4 pi)) = sqrt(pi / 3).
    Texels hold terms times a weight, which is alpha: probes inside of walls have 0. */
export const gridChunk = /* glsl */ `
precision highp sampler3D;
uniform sampler3D grid0, grid1, grid2, grid3; // terms 1, y, z, x
uniform vec3 gridLower, gridUpper; // grid.json, m

vec3 gridIrradiance(vec3 position, vec3 normal) {
    vec3 at = (position - gridLower) / (gridUpper - gridLower);
    vec4 mean = texture(grid0, at);
    vec3 slope = texture(grid1, at).rgb * normal.y + texture(grid2, at).rgb * normal.z + texture(grid3, at).rgb * normal.x;
    return max(0.886227 * mean.rgb + 1.023327 * slope, 0.0) / max(mean.a, 1e-3);
}
`;
