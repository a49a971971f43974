/* Scenes of third-party volumes that several figures show. */
#ifndef TY_FIGURES_FLD_VOLUMES_H
#define TY_FIGURES_FLD_VOLUMES_H

/* A CT head, and the file below the folder of third-party data that it needs. */
extern const char fld_ct_file[], fld_ct_scene[];

#endif
