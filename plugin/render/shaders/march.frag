#version 330 core
// A volume as rays see it that march through its bounding box, as far as what else is seen in the pixel (Minho, chapter 4). Colours
// as they are, brighter towards the sun, with the opacity in alpha; multiplied by it.
in vec2 screen;
out vec4 color;
uniform vec3 ray, ray_x, ray_y;  // from the eye through the middle of the picture, 1 m deep; how it moves across the picture
uniform sampler2D depth;         // of what else is seen
uniform int depth_texels;        // of a pixel, each way
uniform vec2 depth_to_distance;  // distance = y / (x + 2 depth - 1)
uniform float pixel_m;           // width of a pixel at 1 m
uniform mat4 to_voxels;          // world axes about the eye -> voxels from the volume's corner
uniform vec3 to_sun;             // in the volume's axes
uniform float threshold;          // what hides less hides nothing
uniform float voxel_m;
uniform float shading;            // 1: surfaces have a bright and a dark side, 0: they do not
uniform float sight_m;           // in what hides most 1/e of the light is left after this
uniform sampler3D voxels;        // rgb: square roots of linear colour, multiplied by alpha: how much it hides
uniform sampler3D blocks;        // 0 where a block of voxels, and one voxel around it, hides nothing
const float kBlockSide = 8.0;
const int kStepsMost = 2048;
const float kShade = 0.4, kSun = 0.8;  // light on a surface: in its own shadow, and what the sun adds
const float kHidden = 0.02;      // of the light: less is not followed any further

// Noise that looks even beside its neighbours' (Jimenez 2014): steps of neighbouring rays do not end in one plane.
float noise(vec2 at) { return fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715)))); }

// What is beyond the volume hides nothing.
float alpha_at(vec3 at, vec3 size) {
    bool is_inside = all(greaterThanEqual(at, vec3(0.0))) && all(lessThanEqual(at, size));
    return is_inside ? texture(voxels, at / size).a : 0.0;
}

void main() {
    vec3 sight = ray + screen.x * ray_x + screen.y * ray_y;
    vec3 size = vec3(textureSize(voxels, 0));
    vec3 from = (to_voxels * vec4(0.0, 0.0, 0.0, 1.0)).xyz, way = mat3(to_voxels) * sight;
    way = mix(way, vec3(1e-7), lessThan(abs(way), vec3(1e-7)));
    vec3 a = -from / way, b = (size - from) / way;
    vec3 enters = min(a, b), leaves = max(a, b);
    // Depths along the line of sight of the camera, as the picture has them.
    float begin = max(max(enters.x, enters.y), max(enters.z, 0.0)), end = min(leaves.x, min(leaves.y, leaves.z));
    float seen = texelFetch(depth, depth_texels * ivec2(gl_FragCoord.xy), 0).r;
    if (seen < 1.0) end = min(end, depth_to_distance.y / (depth_to_distance.x + 2.0 * seen - 1.0));
    color = vec4(0.0);
    if (begin >= end) return;

    // A step is half a voxel; where a pixel is wider than that, a pixel; never more of them than kStepsMost.
    float metres = length(sight), least = 0.5 * voxel_m / metres;
    least = max(least, (end - begin) / float(kStepsMost));
    float left = 1.0;
    float t = begin + noise(gl_FragCoord.xy) * max(least, pixel_m * begin);
    for (int i = 0; i < 2 * kStepsMost && t < end; ++i) {
        vec3 at = from + t * way;
        vec3 block = floor(clamp(at, vec3(0.0), size - 0.5) / kBlockSide);
        float step = max(least, pixel_m * t);
        if (texelFetch(blocks, ivec3(block), 0).r == 0.0) {
            // To the far side of the block, by whole steps: so places do not depend on what was left out.
            vec3 out_of = ((block + vec3(greaterThan(way, vec3(0.0)))) * kBlockSide - from) / way;
            t += step * max(1.0, ceil((min(out_of.x, min(out_of.y, out_of.z)) - t) / step));
            continue;
        }
        vec4 here = texture(voxels, at / size);
        float dense = (here.a - threshold) / (1.0 - threshold);
        if (dense > 0.0) {
            vec3 shade = vec3(0.0);
            for (int axis = 0; axis < 3; ++axis) {
                vec3 off = vec3(0.0);
                off[axis] = 1.0;
                shade[axis] = alpha_at(at - off, size) - alpha_at(at + off, size);
            }
            float steep = length(shade);
            float sunlit = steep > 0.0 ? dot(shade, to_sun) / steep : 0.0;
            vec3 base = here.rgb / here.a;
            float hides = 1.0 - exp(-dense * step * metres / sight_m);
            // What is even inside has its own colour; a surface has a bright and a dark side.
            float light = mix(1.0, kShade + kSun * max(sunlit, 0.0), shading * min(1.0, 2.0 * steep));
            color.rgb += left * hides * base * base * light;
            left *= 1.0 - hides;
            if (left < kHidden) {
                left = 0.0;
                break;
            }
        }
        t += step;
    }
    float hidden = 1.0 - left;
    color = vec4(pow(color.rgb / max(hidden, 1e-4), vec3(1.0 / 2.2)) * hidden, hidden);
}
