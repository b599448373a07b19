#version 330 core
// A cloud of dust: a square that faces the eye. One instance each.
layout(location = 0) in vec4 center_radius;  // about the eye [m]
layout(location = 1) in vec4 color_alpha;    // of the soil; how much the middle hides
layout(location = 2) in vec4 seed;           // of its pattern, 0..1
uniform mat4 clip;          // world axes about the eye -> clip space
uniform vec3 aside, above;  // the picture's axes in the world
uniform vec3 sight;         // of the camera, unit
uniform sampler2D depth;         // of what else is seen
uniform vec2 depth_to_distance;  // distance = y / (x + 2 depth - 1)
out vec2 at;                // in the cloud, -1..1
out vec3 pattern;           // place in the volume of noise
flat out vec4 lit;
flat out float away, radius;  // along the sight [m]
// Dust is lit from all sides and scatters most of it: most of the sun, all of the sky (light.frag).
const vec3 kLight = vec3(1.20, 1.10, 1.00);
const float kPale = 0.3;  // finer than the soil, so paler
vec3 filmic(vec3 x) { return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); }
void main() {
    at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec3 world = center_radius.xyz + center_radius.w * (at.x * aside + at.y * above);
    pattern = seed.xyz + 0.06 * (at.x * aside + at.y * above);
    vec3 color = mix(color_alpha.rgb, vec3(dot(color_alpha.rgb, vec3(0.3, 0.5, 0.2))), 0.2);
    lit = vec4(pow(filmic(0.66 * mix(color, vec3(0.8), kPale) * kLight), vec3(1.0 / 2.2)), color_alpha.a);
    away = dot(center_radius.xyz, sight);
    radius = center_radius.w;
    // A cloud whose middle lies behind a wall does not come through it.
    vec4 middle = clip * vec4(center_radius.xyz, 1.0);
    float seen = textureLod(depth, 0.5 + 0.5 * middle.xy / middle.w, 0.0).r;
    float behind = seen < 1.0 ? away - depth_to_distance.y / (depth_to_distance.x + 2.0 * seen - 1.0) : 0.0;
    lit.a *= clamp(1.0 - behind / (0.2 * radius), 0.0, 1.0);
    gl_Position = clip * vec4(world, 1.0);
}
