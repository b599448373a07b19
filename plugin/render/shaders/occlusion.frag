#version 330 core
// Reads the depth of the view; writes the share of the sky that near surfaces leave open.
// Horizon-free variant: points of a spiral disc around the pixel are placed in view space, and each
// occludes by its angle above the tangent plane, less with distance.
in vec2 screen;
out float open_share;
uniform sampler2D depth;
uniform mat4 to_view;     // clip space -> view space
uniform float radius_m;
uniform float focal;      // clip units at distance 1
const int kTapCount = 14;
const float kBias = 0.08;  // sine of the angle below which a point does not occlude: hides facets

vec3 view_position(vec2 uv) {
    vec4 p = to_view * vec4(2.0 * vec3(uv, texture(depth, uv).r) - 1.0, 1.0);
    return p.xyz / p.w;
}

void main() {
    vec2 uv = 0.5 * screen + 0.5;
    if (texture(depth, uv).r >= 1.0) {
        open_share = 1.0;
        return;
    }
    vec3 p = view_position(uv);
    // The flatter of the two differences each way is the one that stays on the surface.
    vec2 texel = 1.0 / vec2(textureSize(depth, 0));
    vec3 right = view_position(uv + vec2(texel.x, 0)) - p, left = p - view_position(uv - vec2(texel.x, 0));
    vec3 up = view_position(uv + vec2(0, texel.y)) - p, down = p - view_position(uv - vec2(0, texel.y));
    vec3 normal = normalize(cross(abs(right.z) < abs(left.z) ? right : left,
                                  abs(up.z) < abs(down.z) ? up : down));
    float reach = clamp(0.5 * focal * radius_m / -p.z, 3.0 * texel.y, 0.2);
    float aspect = texel.x / texel.y;
    // A 4 x 4 pattern of turns, which the smoothing pass averages away.
    ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
    float turn = float((cell.x * 4 + cell.y * 7 + cell.x * cell.y) & 15) / 16.0;
    float sum = 0.0;
    for (int i = 0; i < kTapCount; ++i) {
        float along = (float(i) + 0.5) / float(kTapCount);
        float angle = 6.2832 * (turn + along * 5.0);
        vec2 at = uv + reach * sqrt(along) * along * vec2(aspect * cos(angle), sin(angle));
        vec3 d = view_position(at) - p;
        float distance_m = length(d) + 1e-6;
        float rise = dot(d, normal) / distance_m - kBias;
        sum += max(rise, 0.0) * max(0.0, 1.0 - distance_m / (1.5 * radius_m));
    }
    open_share = clamp(1.0 - 2.2 * sum / float(kTapCount), 0.0, 1.0);
}
