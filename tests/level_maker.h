/* Files for scenes to name: small volumes, a closed mesh, a level with lights and cameras. */
#ifndef TY_TESTS_LEVEL_MAKER_H
#define TY_TESTS_LEVEL_MAKER_H

#include "mesh_maker.h"

/* A NRRD of 2 x 1 x 1 voxels, one unit apart, with the values of the first, then of the second. */
static inline void put_nrrd(const char* path, int components, const char* values) {
    char text[512];
    const bool several = components > 1;
    snprintf(text, sizeof text,
             "NRRD0004\ntype: float\ndimension: %d\nsizes: %.*s 2 1 1\nspacings: %s1 1 1\nencoding: ascii\n\n%s\n",
             several ? 4 : 3, several, components == 3 ? "3" : "2", several ? "nan " : "", values);
    put_text(path, text);
}

/* A closed tetrahedron of the origin and the unit points. */
static inline void put_tetrahedron(const char* path) {
    put_text(path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n");
}

/* A level: the tetrahedron, glowing, a lamp at (0, 2, 0), and two cameras that look along -z from (0, 0, 5) and (1, 2,
 * 3); its numbers are in level.bin. */
static inline void put_level(void) {
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint8_t indices[] = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
    uint8_t data[60];
    memcpy(data, positions, 48);
    memcpy(data + 48, indices, 12);
    put_file("level .bin", data, sizeof data);
    put_text("level.gltf",
             quoted("{'asset':{'version':'2.0'},'scenes':[{'nodes':[0,1,2,3]}],"
                    "'nodes':[{'mesh':0},{'camera':0,'translation':[0,0,5]},{'camera':1,'translation':[1,2,3]},"
                    "{'translation':[0,2,0],'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                    "'cameras':[{'type':'perspective','name':'front','perspective':{'yfov':1,'znear':0.1}},"
                    "{'type':'perspective','name':'side','perspective':{'yfov':0.5,'znear':0.1}}],"
                    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':3}]}},"
                    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]}],"
                    "'materials':[{'emissiveFactor':[1,1,1]}],"
                    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
                    "{'bufferView':1,'componentType':5121,'count':12,'type':'SCALAR'}],"
                    "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':12}],"
                    "'buffers':[{'byteLength':60,'uri':'level%20.bin'}]}"));
}

#endif
