#!/bin/sh
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
# Runs a program on whose disk no file gets larger than 50 kB: writing more fails, as on a full disk.
trap '' XFSZ
ulimit -f 100
exec "$@"
