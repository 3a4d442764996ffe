extends Node
## Shows each case in a viewport of its own until it has converged, and saves a screenshot.

const PATIENCE_FRAMES := 3000


func _ready() -> void:
	var arguments := arguments_by_name()
	var cases: Array = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	for case: Dictionary in cases:
		var begin := Time.get_ticks_msec()
		var viewport := LumivoxCase.viewport(case)
		add_child(viewport)
		var converged := await until_converged(viewport)
		if not converged:
			push_error("%s does not converge: %s" % [case.name, Lumivox.get_status(viewport)])
		if case.output.taa or case.output.scaling == 2.0:
			# What the engine accumulates takes its time.
			for frame in 32:
				await RenderingServer.frame_post_draw
		LumivoxCase.save(viewport, arguments["out"].path_join(case.name))
		print("CASE %s %d ms" % [case.name, Time.get_ticks_msec() - begin])
		viewport.queue_free()
		await get_tree().process_frame
	get_tree().quit()


## The arguments after `--`, as `--name value`.
static func arguments_by_name() -> Dictionary:
	var named := {}
	var arguments := OS.get_cmdline_user_args()
	for i in range(0, arguments.size() - 1, 2):
		named[arguments[i].trim_prefix("--")] = arguments[i + 1]
	return named


static func until_converged(viewport: Viewport) -> bool:
	# The first frames upload; only then is there a status.
	for frame in PATIENCE_FRAMES:
		await RenderingServer.frame_post_draw
		if frame > 3 and Lumivox.is_converged(viewport):
			# What has converged is shown by the next frame.
			await RenderingServer.frame_post_draw
			return true
	return false
