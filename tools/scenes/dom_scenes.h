/* Scenes that benches and figures of discrete ordinates show. */
#ifndef TY_TOOLS_DOM_SCENES_H
#define TY_TOOLS_DOM_SCENES_H

/* The Disney cloud under sun and sky, and the file below the folder of third-party data that it needs. */
extern const char dom_disney_file[], dom_disney_scene[];

#endif
