#version 330 core
// Reads the depth of the view; writes the share of the sky that near surfaces leave open, and the distance for smooth.frag.
// Horizon-free variant: points of a spiral disc around the pixel are placed in view space, and each
// occludes by its angle above the tangent plane, less with distance.
in vec2 screen;
out vec2 open_distance;
uniform sampler2D depth;
uniform vec2 depth_to_distance;  // distance = y / (x + 2 depth - 1)
uniform vec4 to_view;            // a point 1 m deep: xy * screen + zw
uniform float radius_m;
uniform float focal;             // clip units at distance 1
uniform vec2 texel;              // of this picture, 0..1
const float kBias = 0.08;  // sine of the angle below which a point does not occlude: hides facets
// sqrt(a) a along a spiral of five turns, a = 1/24, 3/24 ... 23/24: denser towards the middle.
const int kTapCount = 12;
const vec2 kTaps[kTapCount] = vec2[](
    vec2(0.0022, 0.0082), vec2(-0.0313, -0.0312), vec2(0.0919, 0.0246),
    vec2(-0.1522, 0.0408), vec2(0.1624, -0.1624), vec2(-0.0803, 0.2997),
    vec2(-0.1032, -0.3851), vec2(0.3494, 0.3494), vec2(-0.5758, -0.1543),
    vec2(0.6804, -0.1823), vec2(-0.5788, 0.5788), vec2(0.2428, -0.9062));

vec3 view_position(vec2 uv) {
    float distance_m = depth_to_distance.y / (depth_to_distance.x + 2.0 * texture(depth, uv).r - 1.0);
    return distance_m * vec3(to_view.xy * (2.0 * uv - 1.0) + to_view.zw, -1.0);
}

void main() {
    vec2 uv = 0.5 * screen + 0.5;
    if (texture(depth, uv).r >= 1.0) discard;
    vec3 p = view_position(uv);
    // The flatter of the two differences each way is the one that stays on the surface.
    vec3 right = view_position(uv + vec2(texel.x, 0)) - p, left = p - view_position(uv - vec2(texel.x, 0));
    vec3 up = view_position(uv + vec2(0, texel.y)) - p, down = p - view_position(uv - vec2(0, texel.y));
    vec3 normal = normalize(cross(abs(right.z) < abs(left.z) ? right : left,
                                  abs(up.z) < abs(down.z) ? up : down));
    float reach = clamp(0.5 * focal * radius_m / -p.z, 3.0 * texel.y, 0.2);
    float aspect = texel.x / texel.y;
    // A 4 x 4 pattern of turns, which the smoothing pass averages away.
    ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
    float turn = 6.2832 / 16.0 * float((cell.x * 4 + cell.y * 7 + cell.x * cell.y) & 15);
    mat2 turned = mat2(cos(turn), sin(turn), -sin(turn), cos(turn));
    float sum = 0.0;
    for (int i = 0; i < kTapCount; ++i) {
        vec2 at = uv + reach * vec2(aspect, 1.0) * (turned * kTaps[i]);
        vec3 d = view_position(at) - p;
        float distance_m = length(d) + 1e-6;
        float rise = dot(d, normal) / distance_m - kBias;
        sum += max(rise, 0.0) * max(0.0, 1.0 - distance_m / (1.5 * radius_m));
    }
    open_distance = vec2(clamp(1.0 - 2.2 * sum / float(kTapCount), 0.0, 1.0), -p.z);
}
