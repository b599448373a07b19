#version 330 core
// What is seen in a pixel; light.frag lights it. Triangles of a fine mesh are a few pixels wide, and a software GL shades blocks of
// pixels for each: so little is done here. MIXED is for meshes with several materials, TEXTURED for those with textures.
in vec3 world;
in vec3 world_normal;
in vec3 albedo;
in float wet;
uniform float material;  // row of the table, 0..1; behind it are those of wet soil, in steps of saturation
const float kWetSteps = 8.0, kRow = 1.0 / 255.0;
layout(location = 0) out vec4 albedo_material;  // square roots: dark colours need the finer steps
layout(location = 1) out vec2 octahedral;       // the normal, 0..1
#ifdef MIXED
in vec4 low, high;        // weights of the first four materials, and of the others
uniform vec3 palette[8];  // their colours; 0 of those that there are not
uniform sampler3D blend_map;
uniform mat4 blend_place;  // world axes about the eye -> periods of the map, turned against its axes: so no one sees them
uniform float blend_texel_m;
uniform float pixel_m;     // width of a pixel at 1 m
const float kFadeBegin = 1.0, kFadeEnd = 2.5;  // levels of detail of the map between which it goes over into the mean
const float kLeast = 0.002;

vec3 palette_sum(vec4 a, vec4 b) {
    return a.x * palette[0] + a.y * palette[1] + a.z * palette[2] + a.w * palette[3] + b.x * palette[4] + b.y * palette[5] +
           b.z * palette[6] + b.w * palette[7];
}

// Operator (2) of the Mevea thesis with a blend map. The map has random times e that are exponentially distributed, each material's
// its own. The material with the least e / weight is first with a probability of its share: so areas are as the shares are. A high
// power of weight / e in place of a choice keeps borders smooth.
vec3 mixed_albedo() {
    float sum = dot(low + high, vec4(1.0));
    vec3 mean = palette_sum(low, high) / sum;
    float lod = log2(pixel_m * length(world) / blend_texel_m);
    float fade = smoothstep(kFadeBegin, kFadeEnd, lod);
    vec4 most = max(low, high);
    bool is_alone = sum - max(max(most.x, most.y), max(most.z, most.w)) < 0.01;
    if (is_alone || fade >= 1.0) return albedo;
    vec3 at = (blend_place * vec4(world, 1.0)).xyz;
    vec4 a = low / (textureLod(blend_map, at, lod) + kLeast);
    a = a * a;
    a = a * a;
    vec4 b = vec4(0.0);
    if (high != vec4(0.0)) {
        b = high / (textureLod(blend_map, at.yzx + 0.37, lod) + kLeast);
        b = b * b;
        b = b * b;
    }
    vec3 blended = palette_sum(a, b) / dot(a + b, vec4(1.0));
    return albedo * mix(blended, mean, fade) / max(mean, vec3(0.004));
}
#endif
#ifdef TEXTURED
in vec2 texel;
uniform sampler2D skin;
uniform float is_skinned;  // 1; 0: triangles with colours
#endif
void main() {
    float row = material + kRow * floor(kWetSteps * wet + 0.5);
    vec3 n = world_normal / (abs(world_normal.x) + abs(world_normal.y) + abs(world_normal.z));
    vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    octahedral = 0.5 + 0.5 * (n.z < 0.0 ? folded : n.xy);
#ifdef MIXED
    albedo_material = vec4(sqrt(mixed_albedo()), row);
#elif defined(TEXTURED)
    albedo_material = vec4(sqrt(mix(albedo, texture(skin, texel).rgb, is_skinned)), row);
#else
    albedo_material = vec4(sqrt(albedo), row);
#endif
}
