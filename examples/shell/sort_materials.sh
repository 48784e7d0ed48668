#!/bin/sh
# sort_materials.sh [FOLDER]: fits every file of a folder and lists the materials from smooth to rough; those whose fit is poor are
# named. Without a folder it makes three materials of its own.
set -eu

folder=${1:-materials}
if [ $# -eq 0 ]; then
    mkdir -p "$folder"
    for alpha in 0.1 0.25 0.6; do
        facetfit simulate ggx+lambert --set "alpha=$alpha,f0=0.05,kd=0.2" --noise 0.01 -o "$folder/rough_$alpha.csv"
    done
fi

# One run for all files: a JSON for each, and a row for each in the summary. Exit status 1: a fit did not converge.
facetfit fit "$folder"/*.csv --shape isotropic -o fits --summary fits.csv --no-times >log.txt || [ $? -eq 1 ]

# Columns are found by their names, since later versions may have more.
column() {
    head -n 1 fits.csv | tr ',' '\n' | grep -n -x "$1" | cut -d : -f 1
}
alpha=$(column alpha_x) json=$(column json)
tail -n +2 fits.csv | sort -t , -k "$alpha,$alpha" -g >sorted.csv
echo "alpha    file"
while IFS= read -r row; do
    printf '%.4f   %s\n' "$(echo "$row" | cut -d , -f "$alpha")" "$(echo "$row" | cut -d , -f 1)"
done <sorted.csv

# From a fit on: a renderer's file, and the reflectance as C.
smoothest=$(head -n 1 sorted.csv)
result=fits/$(echo "$smoothest" | cut -d , -f "$json")
facetfit export "$result" --to mitsuba -o smoothest.xml >/dev/null
facetfit export "$result" --to c -o smoothest.c >/dev/null
echo "smoothest.xml and smoothest.c are of $(echo "$smoothest" | cut -d , -f 1)"
