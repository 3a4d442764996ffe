@tool
extends "res://tests/editor/driver.gd"
## Makes a volume's node show nothing, or less, in several ways, and tells what the scene dock warns of.

var _volume: LumivoxVolume3D


func _run() -> void:
	while EditorInterface.get_resource_filesystem().is_scanning():
		await get_tree().process_frame
	await _seconds(1.0)
	await _open()
	_tell("content", await _warns("", func() -> void: pass))
	_tell("density", await _warns("'Density' is 0", _volume.set.bind("density", 0.0)))
	_volume.density = 2.0
	var function := LumivoxTransferFunction.new()
	_tell("knots", await _warns("no opacity knots", _volume.set.bind("transfer_function", function)))
	# It is the function that changes, not the node.
	_tell("knots_added", await _warns("", function.set.bind("opacity_knots", [Vector2(0.0, 1.0)] as PackedVector2Array)))
	_tell("flat", await _warns("is flat", _volume.set.bind("clip_max", Vector3(1.0, 0.0, 1.0))))
	_volume.clip_max = Vector3(0.2, 1.0, 1.0)
	_tell("inverted", await _warns("lies beyond", _volume.set.bind("clip_min", Vector3(0.8, 0.0, 0.0))))
	await _seconds(0.3)
	var inverted := _clip_lines()
	_volume.clip_min = Vector3(0.2, 0.0, 0.0)
	_volume.clip_max = Vector3(0.8, 1.0, 1.0)
	await _seconds(0.3)
	_tell("gizmo", not inverted.is_empty() and inverted == _clip_lines())
	_tell("clipped", await _warns("", func() -> void: pass))
	await _slice()
	await _embedded()
	await _seconds(1.0)
	get_tree().quit()


## A scene with a node that shows a scan from a file of its own.
func _open() -> void:
	ResourceSaver.save(LumivoxVolume.phantom("cube", 16), "res://cube.res")
	var root := Node3D.new()
	root.name = "Root"
	var node := LumivoxVolume3D.new()
	node.name = "Warned"
	node.volume = load("res://cube.res")
	root.add_child(node)
	node.owner = root
	var packed := PackedScene.new()
	packed.pack(root)
	ResourceSaver.save(packed, "res://warned.tscn")
	root.free()
	EditorInterface.open_scene_from_path("res://warned.tscn")
	EditorInterface.set_main_screen_editor("3D")
	await _seconds(0.5)
	_volume = EditorInterface.get_edited_scene_root().get_node("Warned")
	EditorInterface.get_selection().add_node(_volume)
	EditorInterface.edit_node(_volume)
	await _seconds(0.5)


## Does something, and waits until the scene dock says so of the node; or says nothing.
func _warns(wanted: String, change: Callable) -> bool:
	change.call()
	return await _until(func() -> bool:
		var text := _said()
		return wanted in text if wanted != "" else text == "")


## What the scene dock warns of at the node; not what its other buttons are for.
func _said() -> String:
	var text := _warnings_of(_volume)
	return text if "warning" in text else ""


## The clip box as the viewport shows it.
func _clip_lines() -> Array:
	for one in _volume.get_gizmos():
		var gizmo := one as EditorNode3DGizmo
		if gizmo != null and gizmo.get_plugin() != null and gizmo.get_plugin().has_method("_clip_box"):
			var lines: PackedVector3Array = gizmo.get_plugin().call("_edges", gizmo.get_plugin().call("_clip_box", _volume))
			var edges := []
			for i in range(0, lines.size(), 2):
				var ends := [lines[i].snappedf(0.001), lines[i + 1].snappedf(0.001)]
				ends.sort()
				edges.append(ends)
			edges.sort_custom(func(a: Array, b: Array) -> bool: return str(a) < str(b))
			return edges
	return []


## One slice of a series instead of the scan.
func _slice() -> void:
	var wanted := "is one slice of a scan"
	_tell("slice", await _warns(wanted, _volume.set.bind("volume", load("res://scans/ct/CT0002.dcm"))))
	_tell("slice_only", not "There is no scan" in _said())
	var offers := func() -> bool:
		return not _find_all(EditorInterface.get_inspector(), func(node: Node) -> bool:
			return node is Button and (node as Button).text == "Use the Whole Scan").is_empty()
	_tell("offered", await _until(offers))
	_tell("none", await _warns("There is no scan to show", _volume.set.bind("volume", null)))
	_tell("taken_back", await _until(func() -> bool: return not offers.call()))
	_tell("whole", await _warns("", _volume.set.bind("volume", load("res://scans/ct/CT0001.dcm"))))


## A scan that goes into the scene's file, and comes out of it.
func _embedded() -> void:
	_volume.volume = LumivoxVolume.phantom("cube", 16)
	_tell("embedded", await _warns("Save it as .res", func() -> void: EditorInterface.save_scene()))
	_tell("own_file", await _warns("", _volume.set.bind("volume", load("res://cube.res"))))
