extends Node
## Uses a volume's node from scripts as nobody should, and from other threads; tells what came of it in lines
## `TELL name JSON`.

const Shower := preload("res://tests/show_cases.gd")
const WRITES := 3000
const PATIENCE_MS := 240_000
## Frames after which an engine that drew nothing will not.
const REST := 20

var _viewport: SubViewport
var _node: LumivoxVolume3D
var _main := OS.get_thread_caller_id()


func _ready() -> void:
	var arguments := Shower.arguments_by_name()
	var all: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(arguments["cases"]))
	_viewport = LumivoxCase.viewport(all.case)
	var heard := {"converged": 0, "arrived": 0, "other": 0}
	for what: String in ["converged", "arrived"]:
		Lumivox.connect(what, func(viewport: Viewport) -> void: heard[what if viewport == _viewport else "other"] += 1)
	add_child(_viewport)
	_node = _viewport.get_child(0).get_node("volumes0")
	if not await Shower.until_converged(_viewport):
		push_error("the volume is not shown")
	heard.progress = Lumivox.get_status(_viewport).progress
	_tell("signals", heard)
	_tell("prepared", await _prepared())
	_tell("labels", _labels())
	await _paint()
	_tell("phantoms", _phantoms())
	_tell("constants", _constants())
	_tell("preset", _preset())
	_tell("colors", _colors())
	_tell("slice", _slice())
	_tell("aligned", _aligned())
	_tell("importer", await _import_on_a_thread(all.series))
	_tell("threads", await _write_on_a_thread())
	_tell("redraws", await _redraws())
	# Last: the values that are left are as far from use as they can be.
	_tell("numbers", _numbers())
	get_tree().quit()


func _tell(what: String, told: Variant) -> void:
	print("TELL %s %s" % [what, JSON.stringify(told)])


## What a node says when what it had computed is there, or cannot be.
func _prepared() -> Dictionary:
	var told := {"prepared": 0, "failed": ""}
	var node := LumivoxVolume3D.new()
	node.volume = LumivoxVolume.phantom("cube", 16)
	node.prepared.connect(func() -> void: told.prepared += 1)
	node.prepare_failed.connect(func(why: String) -> void: told.failed = why)
	node.apply_preset("ct-airways")
	print("EXPECT a warning of airways")
	_viewport.get_child(0).add_child(node)
	var begin := Time.get_ticks_msec()
	while told.prepared == 0 and told.failed == "" and Time.get_ticks_msec() - begin < PATIENCE_MS:
		await RenderingServer.frame_post_draw
	node.queue_free()
	await get_tree().process_frame
	return told


## Paints labels of which the look shows one and hides the other.
func _paint() -> void:
	var node := LumivoxVolume3D.new()
	node.volume = LumivoxVolume.phantom("torso", 48)
	node.apply_preset("ct-bone")
	node.labels = LumivoxLabels.found_in(node.volume)
	node.labels.set_label("body", "painted", true)
	print("EXPECT a warning of paint")
	node.labels.set_label("lungs", "painted", true)
	await get_tree().process_frame
	await get_tree().process_frame
	node.free()


## Looks of labels, and what is said of names that there are not.
func _labels() -> Dictionary:
	var labels := LumivoxLabels.found_in(LumivoxVolume.phantom("torso", 48))
	var told := {"names": labels.get_names(), "set": labels.set_label("lungs", "opacity", 0.25)}
	told.opacity = [labels.get("labels/lungs/opacity"), labels.get_label("lungs", "opacity")]
	print("EXPECT an error of a label")
	told.lung = labels.set_label("Lung", "visible", false)
	print("EXPECT an error of a label")
	labels.set("labels/Nope/visible", false)
	print("EXPECT an error of a field")
	told.field = labels.set_label("lungs", "opactiy", 0.5)
	print("EXPECT an error of a value")
	told.value = labels.set_label("lungs", "opacity", "much")
	print("EXPECT an error of what was not loaded")
	told.of_nothing = LumivoxLabels.found_in(null)
	var other := LumivoxVolume3D.new()
	other.volume = LumivoxVolume.phantom("cube", 16)
	print("EXPECT a warning of the labels of another scan")
	other.labels = labels
	other.free()
	return told


## Every phantom of the command, and one with options.
func _phantoms() -> Dictionary:
	var told := {}
	for kind: String in ["head", "torso", "torso-pet", "mr-head", "mr-brain", "cube", "slab", "sphere"]:
		var volume := LumivoxVolume.phantom(kind, 16)
		told[kind] = volume != null and not volume.is_empty()
	var metal := LumivoxVolume.phantom("torso", 64, {"metal": "rod", "shift": Vector3(0, 60, -40), "seed": 3})
	told.metal = metal.get_value_range().y > LumivoxVolume.phantom("torso", 64).get_value_range().y
	print("EXPECT an error of an option")
	told.unknown = LumivoxVolume.phantom("torso", 16, {"arm": "raised"}) == null
	print("EXPECT an error of an option")
	told.misplaced = LumivoxVolume.phantom("head", 16, {"table": true}) == null
	return told


func _constants() -> Dictionary:
	var told := {}
	for name in ClassDB.class_get_integer_constant_list(&"LumivoxVolume3D", true):
		told[name] = ClassDB.class_get_integer_constant(&"LumivoxVolume3D", name)
	return told


## What is left of colours that are none.
func _colors() -> Array[String]:
	var function := LumivoxTransferFunction.new()
	function.color_values = [-100.0, 0.0, 100.0, NAN] as PackedFloat32Array
	function.colors = [Color(NAN, 0.0, 0.0), Color(-5.0, 1e30, 0.0), Color(0.0, 0.0, INF), Color.RED] as PackedColorArray
	return [function.get_color(-100.0).to_html(false), function.get_color(100.0).to_html(false)] as Array[String]


## What a scene stores of a preset, and what comes back of it.
func _preset() -> Dictionary:
	var node := LumivoxVolume3D.new()
	node.filter = LumivoxVolume3D.FILTER_TRICUBIC
	node.apply_preset("ct-bone")
	node.density = 7.0
	var packed := PackedScene.new()
	packed.pack(node)
	var back: LumivoxVolume3D = packed.instantiate()
	var told := {"preset": back.preset, "density": back.density, "filter": back.filter}
	for property in node.get_property_list():
		if property.name in ["preset", "chosen_preset"]:
			told[property.name + "_usage"] = property.usage
	node.free()
	back.free()
	return told


## What a game that loads one slice of a series is told.
func _slice() -> bool:
	var slice := LumivoxVolume.new()
	slice.set_meta(&"lumivox_series", "res://scans/ct/CT0001.dcm")
	var node := LumivoxVolume3D.new()
	print("EXPECT a warning of one slice")
	node.volume = slice
	var kept := node.volume == slice
	node.free()
	return kept


## How far places of one patient lie apart in two scans of him, before and after they are aligned: in metres.
func _aligned() -> Dictionary:
	var parent := Node3D.new()
	parent.transform = Transform3D(Basis.from_euler(Vector3(0.3, 0.7, -0.2)) * 2.0, Vector3(1.0, 2.0, -3.0))
	add_child(parent)
	var nodes: Array[LumivoxVolume3D] = []
	for kind: String in ["torso", "head"]:
		var node := LumivoxVolume3D.new()
		node.volume = LumivoxVolume.phantom(kind, 16)
		parent.add_child(node)
		nodes.append(node)
	nodes[0].position = Vector3(0.1, 0.2, 0.3)
	var apart := func() -> float:
		var farthest := 0.0
		for point: Vector3 in [Vector3.ZERO, Vector3(100.0, -50.0, 80.0)]:
			var places := nodes.map(func(node: LumivoxVolume3D) -> Vector3:
				return node.global_transform * node.get_patient_transform() * point)
			farthest = maxf(farthest, (places[0] as Vector3).distance_to(places[1] as Vector3))
		return farthest
	var told := {"before": apart.call(), "aligned": nodes[1].align_with(nodes[0])}
	told.after = apart.call()
	var bare := LumivoxVolume3D.new()
	told.refused = [nodes[0].align_with(nodes[0]), nodes[0].align_with(null), bare.align_with(nodes[0])]
	bare.free()
	parent.queue_free()
	return told


## Both that begin an import: one importer is held, one is not.
func _import_on_a_thread(series: String) -> Dictionary:
	var heard := []
	var listen := func(importer: LumivoxImporter) -> void:
		importer.progress.connect(func(_stage: String, _done: int, _total: int) -> void:
			heard.append(["progress", OS.get_thread_caller_id() == _main]))
		importer.finished.connect(func(volume: LumivoxVolume) -> void:
			heard.append(["finished", OS.get_thread_caller_id() == _main and not volume.is_empty()]))
	var held := LumivoxImporter.new()
	listen.call(held)
	var task := WorkerThreadPool.add_task(func() -> void:
		held.start([series])
		var dropped := LumivoxImporter.new()
		listen.call(dropped)
		dropped.start([series]))
	var ended := func() -> bool: return heard.count(["finished", true]) == 2
	var both := await _until(ended)
	WorkerThreadPool.wait_for_task_completion(task)
	return {"finished": both, "on_main": heard.all(func(one: Array) -> bool: return one[1]), "running": held.is_running()}


## A transfer function changes while it is shown.
func _write_on_a_thread() -> Dictionary:
	var function := _node.transfer_function
	var heard := {"main": 0, "elsewhere": 0}
	var listen := func() -> void: heard["main" if OS.get_thread_caller_id() == _main else "elsewhere"] += 1
	function.changed.connect(listen)
	var done := [false]
	var watchdog := Thread.new()
	watchdog.start(func() -> void:
		var begin := Time.get_ticks_msec()
		while not done[0]:
			OS.delay_msec(20)
			if Time.get_ticks_msec() - begin > PATIENCE_MS:
				printerr("ERROR: the game hangs")
				OS.kill(OS.get_process_id()))
	var task := WorkerThreadPool.add_task(func() -> void:
		for i in WRITES:
			function.shift = -0.01 * i
		# Listeners hear of this one here; the node must not.
		function.emit_changed())
	var frames := 0
	while not WorkerThreadPool.is_task_completed(task):
		await RenderingServer.frame_post_draw
		frames += 1
	WorkerThreadPool.wait_for_task_completion(task)
	done[0] = true
	watchdog.wait_to_finish()
	# What a thread has deferred is done after `process_frame` of a frame without a physics step, not before it.
	await _until(func() -> bool: return heard.main >= WRITES)
	await get_tree().process_frame
	function.changed.disconnect(listen)
	var told := {"frames": frames, "heard": heard, "shift": function.shift}
	told.converged = await Shower.until_converged(_viewport)
	return told


func _until(condition: Callable) -> bool:
	var begin := Time.get_ticks_msec()
	while Time.get_ticks_msec() - begin < PATIENCE_MS:
		if condition.call():
			return true
		await get_tree().process_frame
	return false


## Whether an engine that rests draws once a property has changed.
func _redraws() -> Dictionary:
	OS.low_processor_usage_mode = true
	var changes := {
		"density": 1.5, "albedo": 0.5, "anisotropy": 0.4, "max_bounces": 7, "filter": LumivoxVolume3D.FILTER_NEAREST,
		"extinction_space": LumivoxVolume3D.EXTINCTION_WORLD, "surface_strength": 0.5, "surface_gradient": 40.0,
		"surface_roughness": 0.7, "surface_specular": 0.2, "surface_metallic": 0.5, "clip_min": 0.1 * Vector3.ONE, "clip_max": 0.9 * Vector3.ONE,
		"keep_everything": true, "peel_mm": 3.0, "labels": LumivoxLabels.found_in(LumivoxVolume.phantom("head", 24)),
		"transfer_function:shift": 30.0, "preset": "ct-bone", "transfer_function": null,
		"volume": LumivoxVolume.phantom("cube", 16),
	}
	var told := {}
	for property: String in changes:
		if not await _at_rest():
			push_error("the engine does not come to rest before %s" % property)
		if property in ["labels", "volume"]:
			print("EXPECT a warning of labels that are not this scan's")
		var before := Engine.get_frames_drawn()
		_node.set_indexed(property, changes[property])
		for frame in REST:
			await get_tree().process_frame
		told[property] = Engine.get_frames_drawn() - before
	OS.low_processor_usage_mode = false
	return told


func _at_rest() -> bool:
	var begin := Time.get_ticks_msec()
	while Time.get_ticks_msec() - begin < PATIENCE_MS:
		var before := Engine.get_frames_drawn()
		for frame in REST:
			await get_tree().process_frame
		if Lumivox.is_converged(_viewport) and Engine.get_frames_drawn() == before:
			return true
	return false


## Every number of the node: the range that the inspector shows, and what becomes of values beyond it and of none.
func _numbers() -> Dictionary:
	var told := {}
	for property in ClassDB.class_get_property_list(&"LumivoxVolume3D", true):
		var name: String = property.name
		var whole: bool = property.type == TYPE_INT
		if not whole and property.type != TYPE_FLOAT:
			continue
		var set_to := func(value: Variant) -> Variant:
			_node.set(name, value)
			return _node.get(name)
		var one := {"hint": property.hint_string, "enum": property.hint == PROPERTY_HINT_ENUM}
		one.low = set_to.call(-(1 << 40) if whole else -1e30)
		one.high = set_to.call(1 << 40 if whole else 1e30)
		if not whole:
			one.none = []
			for none: float in [NAN, INF, -INF]:
				print("EXPECT an error about %s" % name)
				one.none.append(set_to.call(none))
		told[name] = one
	var corners := []
	for corner: String in ["clip_min", "clip_max"]:
		_node.set(corner, Vector3(-1.0, 0.5, 2.0))
		print("EXPECT an error about %s" % corner)
		_node.set(corner, Vector3(0.0, NAN, 0.0))
		corners.append(_node.get(corner) == Vector3(0.0, 0.5, 1.0))
	var function := LumivoxTransferFunction.new()
	for window: String in ["shift", "window_scale"]:
		function.set(window, 3.0)
		print("EXPECT an error about %s" % window)
		function.set(window, INF)
		corners.append(function.get(window) == 3.0)
	return {"properties": told, "kept": corners}
