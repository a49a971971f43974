// Light on cells (tyndall fluence -o fog.ktx2) in a shader: GLSL ES 3.00, for WebGL2 with three.js or without.

/** The quadrature along a ray. Texels are means of cells: red, green and blue the radiance that media scatter and emit
    per metre, j, and alpha the extinction s. On a step dt both are constant, so that L += T j (1 - e^(-s dt)) / s.

    With FOG_LIGHT defined, media of any mean cosine g: fogTexture is then of tyndall fluence --scattered, and fogUncollided of
    --texture uncollided, whose light comes from fogLight: a point, m (w = 1), or the direction of the sun's light (w = 0). It is
    scattered by the phase function of Henyey and Greenstein; all other light as if isotropically. */
export const fogChunk = /* glsl */ `
precision highp sampler3D;
uniform sampler3D fogTexture;
uniform vec3 fogLower, fogUpper; // the box, m
uniform int fogSteps;

#ifdef FOG_LIGHT
uniform sampler3D fogUncollided; // sigma_s times uncollided fluence, and g
uniform vec4 fogLight;

vec3 fogSingle(vec3 at, vec3 point, vec3 direction) {
    vec4 cell = textureLod(fogUncollided, at, 0.0);
    vec3 travel = normalize(fogLight.w > 0.0 ? point - fogLight.xyz : fogLight.xyz);
    float g = cell.a, cosine = -dot(travel, direction), base = 1.0 + g * g - 2.0 * g * cosine;
    return cell.rgb * (1.0 - g * g) / (12.5663706 * base * sqrt(base));
}
#endif

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
        vec3 at = (point - fogLower) / (fogUpper - fogLower);
        vec4 cell = textureLod(fogTexture, at, 0.0);
#ifdef FOG_LIGHT
        cell.rgb += fogSingle(at, point, direction);
#endif
        float depth = cell.a * dt, through = exp(-depth);
        result.rgb += result.a * cell.rgb * (depth > 1e-3 ? (1.0 - through) / cell.a : dt * (1.0 - 0.5 * depth));
        result.a *= through;
    }
    return result;
}
`;
