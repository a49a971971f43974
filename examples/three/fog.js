// Light on cells (tyndall fluence -o fog.ktx2) in a shader: GLSL ES 3.00, for WebGL2 with three.js or without.

/** The quadrature along a ray. Texels are means of cells: red, green and blue the radiance that media scatter and emit
    per metre, j, and alpha the extinction s. On a step dt both are constant, so that L += T j (1 - e^(-s dt)) / s.

    With FOG_LIGHT defined, media of any mean cosine g: the textures are then those of tyndall fluence --texture phase. fogUncollided
    has the unscattered light of one lamp or sun, fogLight: a point, m (w = 1), or the direction of the sun's light (w = 0). It is
    scattered by the phase function of Henyey and Greenstein. fogDirections has blocks of slices, fogBlocks of them: of all other
    light the axis of the lobe in which the part w is scattered (w is its length) with the lobe's mean cosine x, and then terms of
    spherical harmonics; the last block has factors of the channels. FOG_BANDS is 5, or 3 to read three of the seven blocks before it,
    or 1 for the lobe alone. An engine whose own
    lamps light its fog defines FOG_DIRECTIONS instead of FOG_LIGHT, which leaves their light out. */
export const fogChunk = /* glsl */ `
precision highp sampler3D;
uniform sampler3D fogTexture;
uniform vec3 fogLower, fogUpper; // the box, m
uniform int fogSteps;

#if defined(FOG_LIGHT) || defined(FOG_DIRECTIONS)
#ifndef FOG_BANDS
#define FOG_BANDS 5
#endif
uniform sampler3D fogDirections;
const int fogBlocks = 8;

// 4 pi times Henyey and Greenstein's phase function of mean cosine x.
float fogPhase(float cosine, float x) {
    float base = 1.0 + x * x - 2.0 * x * cosine;
    return (1.0 - x * x) / (base * sqrt(base));
}

vec4 fogBlock(vec3 at, int block) {
    float slices = float(textureSize(fogDirections, 0).z / fogBlocks);
    float slice = clamp(at.z * slices, 0.5, slices - 0.5) + float(block) * slices;
    return textureLod(fogDirections, vec3(at.xy, slice / (slices * float(fogBlocks))), 0.0);
}

// The factor of the light that is scattered along a direction w of travel.
vec3 fogAlongDirection(vec3 at, vec3 w) {
    vec4 lobe = fogBlock(at, 0);
    float part = max(length(lobe.xyz), 1e-6), x = w.x, y = w.y, z = w.z, x2 = x * x, y2 = y * y, z2 = z * z;
    float factor = 1.0 + part * (fogPhase(dot(lobe.xyz, w) / part, lobe.w) - 1.0);
#if FOG_BANDS > 1
    factor += dot(fogBlock(at, 1), vec4(0.488602512 * y, 0.488602512 * z, 0.488602512 * x, 1.092548431 * x * y));
    factor += dot(fogBlock(at, 2), vec4(1.092548431 * y * z, 0.315391565 * (3.0 * z2 - 1.0), 1.092548431 * x * z, 0.546274215 * (x2 - y2)));
#endif
#if FOG_BANDS > 3
    factor += dot(fogBlock(at, 3), vec4(0.590043590 * y * (3.0 * x2 - y2), 2.890611443 * x * y * z, 0.457045799 * y * (5.0 * z2 - 1.0),
                                        0.373176333 * z * (5.0 * z2 - 3.0)));
    factor += dot(fogBlock(at, 4), vec4(0.457045799 * x * (5.0 * z2 - 1.0), 1.445305721 * z * (x2 - y2), 0.590043590 * x * (x2 - 3.0 * y2),
                                        2.503342942 * x * y * (x2 - y2)));
    factor += dot(fogBlock(at, 5), vec4(1.770130769 * y * z * (3.0 * x2 - y2), 0.946174696 * x * y * (7.0 * z2 - 1.0),
                                        0.669046544 * y * z * (7.0 * z2 - 3.0), 0.105785547 * (z2 * (35.0 * z2 - 30.0) + 3.0)));
    factor += dot(fogBlock(at, 6), vec4(0.669046544 * x * z * (7.0 * z2 - 3.0), 0.473087348 * (x2 - y2) * (7.0 * z2 - 1.0),
                                        1.770130769 * x * z * (x2 - 3.0 * y2), 0.625835735 * (x2 * x2 - 6.0 * x2 * y2 + y2 * y2)));
#endif
    return max(1.0 + (factor - 1.0) * fogBlock(at, 7).rgb, 0.0);
}
#endif

#ifdef FOG_LIGHT
uniform sampler3D fogUncollided; // sigma_s times uncollided fluence, and g
uniform vec4 fogLight;

vec3 fogSingle(vec3 at, vec3 point, vec3 direction) {
    vec4 cell = textureLod(fogUncollided, at, 0.0);
    vec3 travel = normalize(fogLight.w > 0.0 ? point - fogLight.xyz : fogLight.xyz);
    return cell.rgb * fogPhase(-dot(travel, direction), cell.a) / 12.5663706;
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
#if defined(FOG_LIGHT) || defined(FOG_DIRECTIONS)
        cell.rgb *= fogAlongDirection(at, -direction);
#endif
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
