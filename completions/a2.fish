complete -c a2 -o input -d 'Scene to read, .txt; the flag may be left out' -r -F
complete -c a2 -o output -d 'Colour picture: .png, or numbers: .pfm, .exr' -r -F
complete -c a2 -o depth -d 'Grey picture of the distance, .png; or auto FILE' -r -F
complete -c a2 -o depth-background -d 'Its colour where nothing is hit [0 0 0]' -r -F
complete -c a2 -o normals -d 'Picture of the surface normals, .png' -r -F
complete -c a2 -o size -d 'Width and height in pixels [100 100]' -r -f
complete -c a2 -o bounces -d 'Mirror reflections one after another [0]' -r -f
complete -c a2 -o samples -d 'As many random samples a pixel [16]' -r -f
complete -c a2 -o sampler -d 'independent, stratified or sobol samples' -r -f -a "independent\t''
stratified\t''
sobol\t''"
complete -c a2 -o epsilon -d 'Where shadow and mirror rays start [0.01], or auto' -r -f
complete -c a2 -o seed -d 'Seed of the random samples [0]' -r -f
complete -c a2 -o report -d 'Write the same as .json' -r -F
complete -c a2 -o reference -d 'Picture that counts as true: say the error' -r -F
complete -c a2 -o error-map -d 'Picture of the estimated error, .png' -r -F
complete -c a2 -o convergence -d 'Error against time: .svg, .html or .csv' -r -F
complete -c a2 -o target-error -d 'Sample where needed until the error is below' -r -f
complete -c a2 -o time-limit -d 'Stop in time with the best picture so far' -r -f
complete -c a2 -o pixel -d 'Print how this pixel gets its colour' -r -f
complete -c a2 -o cost -d 'Picture of what each pixel takes, .png' -r -F
complete -c a2 -o threads -d 'Worker threads [one for each processor]' -r -f
complete -c a2 -o simd -d 'Instruction set: sse2, avx2 or avx512 [the best]' -r -f -a "sse2\t''
avx2\t''
avx512\t''"
complete -c a2 -o max-memory -d 'Refuse what needs more memory, as in 500M' -r -f
complete -c a2 -o region -d 'Render only this part, from the top left' -r -f
complete -c a2 -o tile -d 'Render only part I of N: some rows' -r -f
complete -c a2 -o merge -d 'Join parts to one picture instead of rendering' -r -f
complete -c a2 -o compare -d 'Compare two pictures instead of rendering' -r -F
complete -c a2 -o diff -d 'A, B and their differences side by side, .png' -r -F
complete -c a2 -o tolerance -d 'What counts as alike [1 0.01]' -r -f
complete -c a2 -o check -d 'Read all files and find mistakes, render nothing'
complete -c a2 -o shadows -d 'A light is blocked by what stands before it'
complete -c a2 -o jitter -d '16 random samples a pixel, not one in its corner'
complete -c a2 -o filter -d 'Smooth: render 3 times as large, then shrink'
complete -c a2 -o robust -d 'Right at every scale, not the course\'s shortcuts'
complete -c a2 -o stats -d 'Print times, rays, memory and estimated error'
complete -c a2 -o explain -d 'Say what the scene needs and what is left out'
complete -c a2 -o plain -d 'Render by the plain definition: slow, same bytes'
complete -c a2 -o quiet -d 'No progress and no hints'
complete -c a2 -o skip-done -d 'Leave alone what the same run has finished before'
complete -c a2 -o h -d 'The flags to begin with'
complete -c a2 -o help -d 'All flags, with details and examples'
complete -c a2 -o version -d 'Version, build, instruction sets, limits; also -V'
