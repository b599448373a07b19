#version 330 core
// Mean of the 4 x 4 pixels the occlusion's pattern covers, of like distance only.
out float open_share;
uniform sampler2D occlusion;  // the share of the sky, and the distance; 0 where there is nothing
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(occlusion, 0) - 1;
    float own = texelFetch(occlusion, here, 0).g;
    if (own == 0.0) discard;
    float sum = 0.0, weight = 0.0;
    for (int y = -2; y < 2; ++y) {
        for (int x = -2; x < 2; ++x) {
            vec2 there = texelFetch(occlusion, clamp(here + ivec2(x, y), ivec2(0), last), 0).rg;
            // 1 - own / there: how much further away, of that distance.
            float w = there.g == 0.0 ? 0.0 : max(1e-3, 1.0 - 60.0 * abs(1.0 - own / there.g));
            sum += w * there.r;
            weight += w;
        }
    }
    open_share = sum / weight;
}
