#version 330 core
// Lights what surface.frag has seen: sun with soft-edged shadows, sky and bounce light by the normal's height, ambient occlusion;
// grains of soil from a volume of noise. Writes the picture's own sRGB colours, and in alpha a number by which edges.frag tells
// one face from the next. Drawn at the far plane where the depth is less: a software GL then leaves out blocks of pixels.
in vec2 screen;
out vec4 color;

uniform sampler2D depth;
uniform sampler2D albedo_material;
uniform sampler2D octahedral;
// Texel (0, m): scale of grains, gloss, emission, 1 if it fades, below 0 a film of water; (1, m): origin of the grains, least
// share of the sun.
uniform sampler2D materials;
uniform vec3 ray, ray_x, ray_y;     // from the eye through the middle of the picture, 1 m deep; how it moves across the picture
uniform vec2 depth_to_distance;     // distance = y / (x + 2 depth - 1)
uniform float pixel_m;              // width of a pixel at 1 m
uniform vec3 up;
uniform vec3 to_sun;
uniform vec3 horizon_color;
uniform sampler2DShadow shadow_map;
const int kCascadesMost = 3;
uniform mat4 shadow_clip[kCascadesMost];     // world axes about the eye -> each shadow map, 0..1; they lie side by side
uniform float shadow_bias_m[kCascadesMost];  // along the normal: keeps a surface out of its own shadow
uniform float map_count;                     // that the texture has room for
uniform sampler2D occlusion;
uniform sampler3D grains;      // xyz: a direction, w: a brightness, both about 0.5
uniform float fade_begin_m, fade_end_m;  // floor: distance from its centre where it goes over into the sky
uniform vec3 fade_center;                // about the eye

// Light of the sun, of the sky above and of the ground below.
const vec3 kSun = vec3(1.30, 1.10, 0.84);
const vec3 kSky = vec3(0.24, 0.29, 0.38);
const vec3 kBounce = vec3(0.17, 0.14, 0.11);
const float kFilmSmooth = 0.85;    // of the grains' roughness that a film of water covers
const float kGrainTexels = 32.0;  // of a period
const float kGrainLodMost = 4.0;  // coarser than that nothing is seen of them

const float kMapRim = 0.004;  // of a map: taps would reach out of it

bool is_beyond(vec3 place) {
    return any(lessThan(place, vec3(kMapRim, kMapRim, 0.0))) || any(greaterThan(place, vec3(1.0 - kMapRim, 1.0 - kMapRim, 1.0)));
}

vec3 place_in_map(int map, vec3 at, vec3 face_normal) {
    return (shadow_clip[map] * vec4(at + shadow_bias_m[map] * face_normal, 1.0)).xyz;
}

// In the first map that has the place; CASCADED: there are several. Four taps, each of which the device blends out of four texels:
// three texels wide, turned against the map's axes.
float sun_share(vec3 at, vec3 face_normal) {
    vec3 place = place_in_map(0, at, face_normal);
    float map = 0.0;
#ifdef CASCADED
    for (int next = 1; next < kCascadesMost; ++next) {
        vec3 next_place = place_in_map(next, at, face_normal);
        bool goes_on = is_beyond(place);
        place = goes_on ? next_place : place;
        map = goes_on ? float(next) : map;
    }
#endif
    if (is_beyond(place)) return 1.0;
    place.x = (place.x + map) / map_count;
    vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
    vec2 a = vec2(1.1, 0.5) * texel, b = vec2(-0.5, 1.1) * texel;
    return 0.25 * (texture(shadow_map, place + vec3(a, 0.0)) + texture(shadow_map, place - vec3(a, 0.0)) +
                   texture(shadow_map, place + vec3(b, 0.0)) + texture(shadow_map, place - vec3(b, 0.0)));
}

// Filmic curve, fit by Krzysztof Narkowicz (2015).
vec3 filmic(vec3 x) { return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); }

float to_the_60th(float x) {
    float x4 = x * x * x * x, x8 = x4 * x4, x16 = x8 * x8;
    return x16 * x16 * x16 * x8 * x4;
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    float depth_here = texelFetch(depth, here, 0).r;
    vec3 sight = ray + screen.x * ray_x + screen.y * ray_y;
    vec4 seen = texelFetch(albedo_material, here, 0);
    vec3 albedo = seen.rgb * seen.rgb;
    int row = int(255.0 * seen.a + 0.5);
    vec4 material = texelFetch(materials, ivec2(0, row), 0), grain_origin = texelFetch(materials, ivec2(1, row), 0);
    vec2 folded = 2.0 * texelFetch(octahedral, here, 0).rg - 1.0;
    vec3 smooth_normal = vec3(folded, 1.0 - abs(folded.x) - abs(folded.y));
    float over = max(-smooth_normal.z, 0.0);
    smooth_normal.xy -= over * vec2(folded.x < 0.0 ? -1.0 : 1.0, folded.y < 0.0 ? -1.0 : 1.0);
    smooth_normal = normalize(smooth_normal);
    float distance_m = depth_to_distance.y / (depth_to_distance.x + 2.0 * depth_here - 1.0);
    vec3 world = distance_m * sight;
    float face = float(row * 37);
    float film = max(-material.w, 0.0);

    vec3 normal = smooth_normal;
    vec3 base = albedo;
    float cavity = 1.0;
    if (material.x > 0.0) {
        vec3 at = world * material.x + grain_origin.xyz;
        // Coarser where the surface turns away: as wide as the pixel's print on it, but for its narrow side.
        float facing = abs(dot(smooth_normal, sight)) * inversesqrt(dot(sight, sight));
        float lod = log2(kGrainTexels * material.x * pixel_m * distance_m / max(facing, 0.3));
        vec4 fine = lod < kGrainLodMost ? textureLod(grains, at, lod) - 0.5 : vec4(0.0);
        vec4 coarse = lod < kGrainLodMost + 3.0 ? textureLod(grains, at * 0.125, lod - 3.0) - 0.5 : vec4(0.0);
        // Shapes are to be seen by their shading: the coarse pattern is no more than a hint.
        vec3 tilt = (1.0 - kFilmSmooth * film) * (0.20 * fine.xyz + 0.08 * coarse.xyz);
        normal = normalize(normal + tilt - dot(tilt, normal) * normal);
        base *= 1.0 + 0.30 * fine.w + 0.12 * coarse.w;
        cavity = 1.0 + 0.5 * fine.w;
        // Steep faces are freshly cut or sheared: a little darker and moister than the crust on top.
        base *= mix(0.78, 1.0, smoothstep(0.2, 0.85, dot(smooth_normal, up)));
    } else {
        vec3 side = floor(2.0 * smooth_normal + 0.5);
        face += 101.0 + dot(side, vec3(3.0, 17.0, 67.0));
    }
    float lambert = dot(normal, to_sun);
    float sun = max(lambert, 0.0);
    // A face turned away by its true normal is in shadow whatever its grains do.
    sun *= smoothstep(-0.05, 0.1, dot(smooth_normal, to_sun));
    if (sun > 0.0) sun *= max(grain_origin.w, sun_share(world, smooth_normal));
    float open_share = texture(occlusion, 0.5 + 0.5 * screen).r;
    vec3 ambient = mix(kBounce, kSky, 0.5 + 0.5 * dot(normal, up)) * open_share * cavity;
    vec3 light = sun * kSun * mix(0.75, 1.0, open_share) + ambient;
    vec3 shaded = base * light;
    if (material.y > 0.0) {
        vec3 to_eye = -normalize(sight);
        float highlight = to_the_60th(max(dot(normal, normalize(to_sun + to_eye)), 0.0));
        float off = 1.0 - max(dot(normal, to_eye), 0.0), rim = off * off * off * off * off;
        shaded += material.y * (0.5 * highlight * sun * kSun + 0.5 * rim * kSky * open_share);
        // A film sends back a fiftieth of the sky that falls on it straight (Fresnel, by Schlick), and no more than a third of what
        // grazes it: it lies on grains.
        shaded += film * mix(0.02, 0.33, rim) * open_share * horizon_color;
    }
    shaded = mix(filmic(0.66 * shaded), albedo, material.z);
    if (material.w > 0.0) {
        float fade = smoothstep(fade_begin_m, fade_end_m, length(world - fade_center));
        shaded = mix(shaded, horizon_color, fade);
    }
    color = vec4(pow(shaded, vec3(1.0 / 2.2)), fract(face / 256.0));
}
