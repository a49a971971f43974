/* The one shader of the page: two images to display colours. */

export const vertexText = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

/* image[0] is the method's, image[1] that of path. u_place: left, top, width and height of the frame in the window, in
 * device pixels; u_jpeg: 1 / 2^stops where an image is a JPEG, else 0; u_there: which images have arrived. */
export const fragmentText = `#version 300 es
precision highp float;
precision highp int;
uniform sampler2D u_method, u_path, u_radiance, u_difference;
uniform vec4 u_place, u_outside;
uniform vec2 u_window, u_jpeg, u_false;
uniform float u_scale, u_wipe, u_range;
uniform bvec2 u_there;
uniform int u_mode, u_curve, u_channel, u_look, u_markers, u_taps;
out vec4 color;

const vec3 weights = vec3(0.2126, 0.7152, 0.0722);

vec3 to_srgb(vec3 x) {
  x = clamp(x, 0.0, 1.0);
  return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}
vec3 from_srgb(vec3 x) {
  return mix(pow((x + 0.055) / 1.055, vec3(2.4)), x / 12.92, lessThanEqual(x, vec3(0.04045)));
}
/* Identity up to 1/2, then a shoulder that tends to 1; and its inverse. */
vec3 filmic(vec3 x) {
  vec3 y = max(2.0 * x - 1.0, 0.0);
  return mix(1.0 - 0.5 / (1.0 + y), x, lessThanEqual(x, vec3(0.5)));
}
vec3 from_filmic(vec3 x) {
  vec3 y = min(2.0 * x - 1.0, 0.992);
  return mix(0.5 + 0.5 * y / (1.0 - y), x, lessThanEqual(x, vec3(0.5)));
}

bool is_number(vec3 x) {
  return all(notEqual(floatBitsToUint(x) & 0x7f800000u, uvec3(0x7f800000u)));
}

vec3 radiance(sampler2D image, vec2 at, float jpeg) {
  vec3 x = vec3(0.0);
  if (u_taps == 1) x = texture(image, at).rgb;
  else {
    vec2 offset = 0.25 / u_place.zw;
    x = 0.25 * (texture(image, at + offset).rgb + texture(image, at - offset).rgb
      + texture(image, at + vec2(offset.x, -offset.y)).rgb + texture(image, at + vec2(-offset.x, offset.y)).rgb);
  }
  return jpeg > 0.0 ? jpeg * from_filmic(from_srgb(x)) : x;
}

float chosen(vec3 x) {
  return u_channel == 1 ? x.r : u_channel == 2 ? x.g : u_channel == 3 ? x.b : dot(x, weights);
}

vec3 shown(vec3 x) {
  if (u_look == 1) {
    float value = max(chosen(x), 1e-30);
    float t = (log(value) / 2.302585093 - u_false.x) / (u_false.y - u_false.x);
    return texture(u_radiance, vec2(clamp(t, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
  }
  x *= u_scale;
  if (u_channel > 0) x = vec3(chosen(x));
  x = max(x, 0.0);
  if (u_curve == 0) return to_srgb(filmic(x));
  if (u_curve == 1) return to_srgb(x);
  if (u_curve == 2) return to_srgb(x / (1.0 + x));
  return clamp(x, 0.0, 1.0);
}

void main() {
  vec2 pixel = vec2(gl_FragCoord.x, u_window.y - gl_FragCoord.y);
  vec2 at = (pixel - u_place.xy) / u_place.zw;
  bool right = u_mode == 1 || u_mode == 2 && at.x >= u_wipe;
  bool there = u_mode == 3 ? all(u_there) : right ? u_there.y : u_there.x;
  if (!there || any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(1.0)))) {
    color = u_outside;
    return;
  }
  vec3 x = right ? radiance(u_path, at, u_jpeg.y) : radiance(u_method, at, u_jpeg.x);
  if (u_mode == 3) {
    x -= radiance(u_path, at, u_jpeg.y);
    float t = clamp(0.5 + 0.5 * chosen(x) / u_range, 0.0, 1.0);
    color = vec4(texture(u_difference, vec2(t * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb, 1.0);
  } else {
    color = vec4(shown(x), 1.0);
  }
  if (u_markers == 1 && !is_number(x))
    color = mod(floor(pixel.x / 4.0) + floor(pixel.y / 4.0), 2.0) < 1.0 ? vec4(1.0, 0.0, 1.0, 1.0) : vec4(0.0, 1.0, 0.0, 1.0);
}`;
