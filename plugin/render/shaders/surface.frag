#version 330 core
// Sun with soft-edged shadows, sky and bounce light by the normal's height, ambient occlusion; grains
// of soil from a volume of noise. Writes the picture's own sRGB colours.
in vec3 world;
in vec3 world_normal;
in vec3 albedo;
in vec3 shadow_place;
out vec4 color;

uniform vec3 up;
uniform vec3 to_sun;
uniform vec3 horizon_color;
uniform sampler2DShadow shadow_map;
uniform sampler2D occlusion;
uniform vec2 picture_size;
uniform sampler3D grains;     // xyz: a direction, w: a brightness, both about 0.5
uniform float grain_scale;    // periods of the grain volume per metre; 0: smooth
uniform vec3 grain_origin;    // of the eye, in periods
uniform float gloss;
uniform float emission;         // 0: lit .. 1: its own colour whatever the light
uniform float fade_begin_m, fade_end_m;  // floor: distance from its centre where it goes over into the sky
uniform vec3 fade_center;                // about the eye; fade_end_m = 0: no fading

// Light of the sun, of the sky above and of the ground below.
const vec3 kSun = vec3(1.30, 1.10, 0.84);
const vec3 kSky = vec3(0.24, 0.29, 0.38);
const vec3 kBounce = vec3(0.17, 0.14, 0.11);

float sun_share(vec3 place) {
    if (any(lessThan(place, vec3(0.0))) || any(greaterThan(place, vec3(1.0)))) return 1.0;
    vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
    float sum = 0.0;
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            sum += texture(shadow_map, place + vec3(1.25 * texel * vec2(x, y), 0.0));
        }
    }
    return sum / 9.0;
}

// Filmic curve, fit by Krzysztof Narkowicz (2015).
vec3 filmic(vec3 x) { return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); }

void main() {
    vec3 normal = normalize(world_normal);
    vec3 base = albedo;
    float cavity = 1.0;
    if (grain_scale > 0.0) {
        vec3 at = world * grain_scale + grain_origin;
        vec4 fine = texture(grains, at) - 0.5;
        vec4 coarse = texture(grains, at * 0.125) - 0.5;
        // Shapes are to be seen by their shading: the coarse pattern is no more than a hint.
        vec3 tilt = 0.20 * fine.xyz + 0.08 * coarse.xyz;
        normal = normalize(normal + tilt - dot(tilt, normal) * normal);
        base *= 1.0 + 0.30 * fine.w + 0.12 * coarse.w;
        cavity = 1.0 + 0.5 * fine.w;
        // Steep faces are freshly cut or sheared: a little darker and moister than the crust on top.
        base *= mix(0.78, 1.0, smoothstep(0.2, 0.85, dot(normalize(world_normal), up)));
    }
    float lambert = dot(normal, to_sun);
    float sun = max(lambert, 0.0);
    // A face turned away by its true normal is in shadow whatever its grains do.
    sun *= smoothstep(-0.05, 0.1, dot(normalize(world_normal), to_sun));
    if (sun > 0.0) sun *= sun_share(shadow_place);
    float open_share = texture(occlusion, gl_FragCoord.xy / picture_size).r;
    vec3 ambient = mix(kBounce, kSky, 0.5 + 0.5 * dot(normal, up)) * open_share * cavity;
    vec3 light = sun * kSun * mix(0.75, 1.0, open_share) + ambient;
    vec3 shaded = base * light;
    if (gloss > 0.0) {
        vec3 to_eye = normalize(-world);
        float highlight = pow(max(dot(normal, normalize(to_sun + to_eye)), 0.0), 60.0);
        float rim = pow(1.0 - max(dot(normal, to_eye), 0.0), 5.0);
        shaded += gloss * (0.5 * highlight * sun * kSun + 0.5 * rim * kSky * open_share);
    }
    shaded = mix(filmic(0.66 * shaded), albedo, emission);
    if (fade_end_m > 0.0) {
        float fade = smoothstep(fade_begin_m, fade_end_m, length(world - fade_center));
        shaded = mix(shaded, horizon_color, fade);
    }
    color = vec4(pow(shaded, vec3(1.0 / 2.2)), 1.0);
}
