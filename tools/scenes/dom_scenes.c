/* Scenes that benches and figures of discrete ordinates show. */
#include "scenes/dom_scenes.h"

const char dom_disney_file[] = "volumes/wdas_cloud_sixteenth.vdb";

const char dom_disney_scene[] =
    "{\"tyndall\": 1,"
    " \"camera\": {\"position\": [-560, 60, 420], \"target\": [0, 45, -40], \"fov_y\": 28, \"resolution\": [960, 540],"
    "  \"exposure\": 1.6},"
    " \"media\": [{\"name\": \"cloud\", \"density\": {\"file\": \"volumes/wdas_cloud_sixteenth.vdb\", \"grid\": "
    "\"density\"},"
    "  \"sigma_t\": 0.5, \"albedo\": 0.999, \"g\": 0.8}],"
    " \"lights\": [{\"type\": \"environment\", \"sky\": {\"sun_direction\": [0.75, -0.5, -0.1], \"haze\": 0.8,"
    "  \"sun\": true}}]}";
