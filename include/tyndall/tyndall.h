/// @file tyndall.h
/// All public headers of Tyndall, a library for light in fog, smoke, clouds, milk and water. Apache-2.0.
#ifndef TYNDALL_TYNDALL_H
#define TYNDALL_TYNDALL_H

#include <tyndall/bake.h>
#include <tyndall/base.h>
#include <tyndall/choose.h>
#include <tyndall/denoise.h>
#include <tyndall/dom.h>
#include <tyndall/fld.h>
#include <tyndall/flux.h>
#include <tyndall/gradient.h>
#include <tyndall/grid.h>
#include <tyndall/image.h>
#include <tyndall/impulse.h>
#include <tyndall/io.h>
#include <tyndall/rsm.h>
#include <tyndall/lpv.h>
#include <tyndall/method.h>
#include <tyndall/octaves.h>
#include <tyndall/path.h>
#include <tyndall/pop.h>
#include <tyndall/scene.h>
#include <tyndall/scene_editor.h>
#include <tyndall/screen.h>
#include <tyndall/texels.h>

#endif
