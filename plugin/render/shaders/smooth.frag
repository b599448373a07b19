#version 330 core
// Mean of the 4 x 4 pixels the occlusion's pattern covers, of like depth only.
in vec2 screen;
out float open_share;
uniform sampler2D occlusion;
uniform sampler2D depth;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(depth, 0) - 1;
    float own = texelFetch(depth, here, 0).r;
    float sum = 0.0, weight = 0.0;
    for (int y = -2; y < 2; ++y) {
        for (int x = -2; x < 2; ++x) {
            ivec2 at = clamp(here + ivec2(x, y), ivec2(0), last);
            // Depth is 1 - near / distance: relative differences of distance are those of 1 - depth.
            float w = exp(-60.0 * abs(texelFetch(depth, at, 0).r - own) / max(1e-6, 1.0 - own));
            sum += w * texelFetch(occlusion, at, 0).r;
            weight += w;
        }
    }
    open_share = sum / max(weight, 1e-4);
}
