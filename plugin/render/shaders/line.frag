#version 330 core
in vec3 albedo;
out vec4 color;  // alpha: that of no face, so that edges are smoothed
void main() { color = vec4(pow(albedo, vec3(1.0 / 2.2)), 0.999); }
