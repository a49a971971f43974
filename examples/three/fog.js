// Light on cells (tyndall fluence -o fog.ktx2) in a shader: GLSL ES 3.00, for WebGL2 with three.js or without.

/** The quadrature along a ray. Texels are means of cells: red, green and blue the radiance that media scatter and emit
    per metre, j, and alpha the extinction s. On a step dt both are constant, so that L += T j (1 - e^(-s dt)) / s. */
export const fogChunk = /* glsl */ `
precision highp sampler3D;
uniform sampler3D fogTexture;
uniform vec3 fogLower, fogUpper; // the box, m
uniform int fogSteps;

// The light that the fog between origin and origin + distance * direction adds (rgb), and its transmittance (a).
vec4 fogAlong(vec3 origin, vec3 direction, float distance) {
    vec3 a = (fogLower - origin) / direction, b = (fogUpper - origin) / direction;
    vec3 low = min(a, b), high = max(a, b);
    float enter = max(max(low.x, max(low.y, low.z)), 0.0), leave = min(min(high.x, min(high.y, high.z)), distance);
    vec4 result = vec4(0.0, 0.0, 0.0, 1.0);
    if (!(enter < leave)) return result;
    float dt = (leave - enter) / float(fogSteps);
    for (int i = 0; i < fogSteps; ++i) {
        vec3 point = origin + (enter + (float(i) + 0.5) * dt) * direction;
        vec4 cell = textureLod(fogTexture, (point - fogLower) / (fogUpper - fogLower), 0.0);
        float depth = cell.a * dt, through = exp(-depth);
        result.rgb += result.a * cell.rgb * (depth > 1e-3 ? (1.0 - through) / cell.a : dt * (1.0 - 0.5 * depth));
        result.a *= through;
    }
    return result;
}
`;
