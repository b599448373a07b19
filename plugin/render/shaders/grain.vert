#version 330 core
// A grain: a triangle that faces the eye, drawn out along its motion. One instance for each part of a group.
layout(location = 0) in vec3 offset;         // of the grain in its cube, 0..1
layout(location = 1) in vec4 center_side;    // about the eye [m]
layout(location = 2) in vec4 shift_grain;    // of all of the part's grains, 0..1; size of one [m]
layout(location = 3) in vec4 streak_count;   // how far it is drawn out [m]; how many there are
layout(location = 4) in vec4 group_color;
layout(location = 5) in vec4 group_flat;     // normal, times the root of how much the cube is pressed flat along it
uniform mat4 clip;    // world axes about the eye -> clip space
uniform vec3 bright;  // towards the light that is scattered from grain to grain: their normals lean to it
uniform vec3 facing;  // what grains face, unit; 0: the eye
out vec3 world;       // about the eye [m]
out vec3 world_normal;
out vec3 albedo;
out float wet;
void main() {
    int grain = gl_VertexID / 3, corner = gl_VertexID % 3;
    albedo = group_color.rgb;
    wet = 0.0;
    world = world_normal = vec3(0.0, 0.0, 1.0);
    if (float(grain) >= streak_count.w) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // out of the picture
        return;
    }
    vec3 in_cube = fract(offset + shift_grain.xyz) - 0.5;
    vec3 place = center_side.xyz + center_side.w * (in_cube - dot(in_cube, group_flat.xyz) * group_flat.xyz);
    vec3 to_eye = facing == vec3(0.0) ? normalize(-place) : facing;
    vec3 chance = 2.0 * fract(offset.yzx * 57.0 + offset.zxy * 13.0) - 1.0;
    float size = shift_grain.w * (0.75 + 0.5 * offset.y);
    vec3 along = streak_count.xyz + size * normalize(chance + vec3(0.01));
    vec3 across = 0.4 * size * normalize(cross(along, to_eye) + vec3(1e-9));
    world = place + (corner == 0 ? -0.5 * along : corner == 1 ? 0.5 * along + across : 0.5 * along - across);
    // On the ground a grain is as bright as its slope.
    bool is_in_air = group_flat.xyz == vec3(0.0);
    world_normal = normalize((is_in_air ? 0.5 * to_eye + bright : 1.5 * group_flat.xyz) + 0.8 * chance);
    albedo *= 0.85 + 0.3 * offset.x;
    gl_Position = clip * vec4(world, 1.0);
}
