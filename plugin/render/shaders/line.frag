#version 330 core
in vec3 albedo;
out vec4 color;
void main() { color = vec4(pow(albedo, vec3(1.0 / 2.2)), 1.0); }
