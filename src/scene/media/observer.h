/* Colour matching functions of the CIE 1931 2 degree observer. */
#ifndef TY_SCENE_MEDIA_OBSERVER_H
#define TY_SCENE_MEDIA_OBSERVER_H

/* Wavelengths, nm. */
enum { TY_OBSERVER_FIRST = 380, TY_OBSERVER_STEP = 5, TY_OBSERVER_COUNT = 81 };

/* x, y and z at each of these wavelengths. */
extern const double ty_observer[TY_OBSERVER_COUNT][3];

#endif
