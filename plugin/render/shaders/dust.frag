#version 330 core
// A cloud of dust: thick in the middle, and nothing where it meets what is seen.
in vec2 at;
in vec3 pattern;
flat in vec4 lit;
flat in float away, radius;
out vec4 color;                  // multiplied by its alpha
uniform sampler2D depth;         // of what else is seen
uniform int depth_texels;        // of a pixel, each way
uniform vec2 depth_to_distance;  // distance = y / (x + 2 depth - 1)
uniform sampler3D grains;        // w: a brightness, about 0.5
void main() {
    float edge = max(0.0, 1.0 - dot(at, at));
    float seen = texelFetch(depth, depth_texels * ivec2(gl_FragCoord.xy), 0).r;
    float room = seen < 1.0 ? depth_to_distance.y / (depth_to_distance.x + 2.0 * seen - 1.0) - away : radius;
    float before = clamp(0.5 + room / radius, 0.0, 1.0);
    float uneven = 0.4 + 1.2 * textureLod(grains, pattern, 0.0).w;
    float alpha = lit.a * edge * edge * before * uneven;
    color = vec4(lit.rgb * alpha, alpha);
}
