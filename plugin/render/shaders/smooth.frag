#version 330 core
// Mean of the 4 x 4 pixels the occlusion's pattern covers, of like depth only.
in vec2 screen;
out float open_share;
uniform sampler2D occlusion;
uniform sampler2D depth;
uniform vec2 texel;  // of this picture, 0..1
void main() {
    vec2 here = 0.5 * screen + 0.5;
    float own = texture(depth, here).r;
    // Depth is 1 - near / distance: relative differences of distance are those of 1 - depth.
    float relative = 60.0 / max(1e-6, 1.0 - own);
    float sum = 0.0, weight = 0.0;
    for (int y = -2; y < 2; ++y) {
        for (int x = -2; x < 2; ++x) {
            vec2 at = here + texel * vec2(x, y);
            float w = max(1e-3, 1.0 - relative * abs(texture(depth, at).r - own));
            sum += w * texture(occlusion, at).r;
            weight += w;
        }
    }
    open_share = sum / weight;
}
