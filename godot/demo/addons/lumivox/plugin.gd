@tool
extends EditorPlugin
## The editor's part of Lumivox: import, gizmo, inspector and the transfer-function dock.

const VolumeImporter := preload("editor/import_plugin.gd")
const DicomImporter := preload("editor/dicom_import_plugin.gd")
const SceneImporter := preload("editor/scene_import_plugin.gd")
const SceneSaver := preload("editor/scene_saver.gd")
const DicomFolders := preload("editor/dicom_folders.gd")
const FormerImports := preload("editor/former_imports.gd")
const MissedFiles := preload("editor/missed_files.gd")
const ImportMenu := preload("editor/import_menu.gd")
const ImportDialog := preload("editor/import_dialog.gd")
const VolumeGizmo := preload("editor/volume_gizmo.gd")
const ClipGizmo := preload("editor/clip_gizmo.gd")
const VolumeInspector := preload("editor/volume_inspector.gd")
const TransferFunctionDock := preload("editor/transfer_function_dock.gd")

const MENU_ITEM := "Import a Scan..."
const SAVE_ITEM := "Save View as Lumivox Scene..."

var _importers: Array[EditorImportPlugin] = []
var _menu := ImportMenu.new()
var _dialog: ImportDialog
var _saver: SceneSaver
var _gizmo: VolumeGizmo
var _clip_gizmo: ClipGizmo
var _inspector: VolumeInspector
var _dock: TransferFunctionDock
var _dock_button: Button


func _enter_tree() -> void:
	# Collected now: the engine does it without a lock when the first volume is saved, and that is in the background.
	ClassDB.class_get_property_default_value(&"LumivoxVolume", &"resource_name")
	_importers = [VolumeImporter.new(), DicomImporter.new(), SceneImporter.new()]
	for importer in _importers:
		add_import_plugin(importer)
	_gizmo = VolumeGizmo.new(get_undo_redo())
	add_node_3d_gizmo_plugin(_gizmo)
	_clip_gizmo = ClipGizmo.new()
	add_node_3d_gizmo_plugin(_clip_gizmo)
	_inspector = VolumeInspector.new(get_undo_redo())
	add_inspector_plugin(_inspector)
	add_undo_redo_inspector_hook_callback(VolumeInspector.record_preset)
	_dock = TransferFunctionDock.new(get_undo_redo())
	_dock_button = add_control_to_bottom_panel(_dock, "Transfer Function")
	_dialog = ImportDialog.new(get_undo_redo())
	EditorInterface.get_base_control().add_child(_dialog)
	add_tool_menu_item(MENU_ITEM, _dialog.open)
	_saver = SceneSaver.new()
	EditorInterface.get_base_control().add_child(_saver)
	add_tool_menu_item(SAVE_ITEM, _saver.open)
	_inspector.import_requested.connect(_dialog.open)
	_menu.chosen.connect(_dialog.open_path)
	add_context_menu_plugin(EditorContextMenuPlugin.CONTEXT_SLOT_FILESYSTEM, _menu)
	get_window().files_dropped.connect(_on_files_dropped)
	add_child(DicomFolders.new())
	add_child(FormerImports.new())
	add_child(MissedFiles.new())
	EditorInterface.get_selection().selection_changed.connect(_on_selection_changed)


func _exit_tree() -> void:
	EditorInterface.get_selection().selection_changed.disconnect(_on_selection_changed)
	get_window().files_dropped.disconnect(_on_files_dropped)
	remove_tool_menu_item(SAVE_ITEM)
	_saver.queue_free()
	remove_tool_menu_item(MENU_ITEM)
	remove_context_menu_plugin(_menu)
	_menu.chosen.disconnect(_dialog.open_path)
	_dialog.queue_free()
	remove_control_from_bottom_panel(_dock)
	_dock.queue_free()
	remove_undo_redo_inspector_hook_callback(VolumeInspector.record_preset)
	remove_inspector_plugin(_inspector)
	remove_node_3d_gizmo_plugin(_clip_gizmo)
	remove_node_3d_gizmo_plugin(_gizmo)
	for importer in _importers:
		remove_import_plugin(importer)
	_importers.clear()


func _handles(object: Object) -> bool:
	return object is LumivoxVolume3D or object is LumivoxTransferFunction


func _edit(object: Object) -> void:
	# The inspector edits a sub-resource of a node: the node stays what the dock follows.
	if object is LumivoxVolume3D:
		_dock.follow_node(object as LumivoxVolume3D)
	elif object is LumivoxTransferFunction:
		_dock.follow_resource(object as LumivoxTransferFunction)


func _make_visible(visible: bool) -> void:
	if visible and _dock_button != null:
		_dock_button.show()
		make_bottom_panel_item_visible(_dock)


func _enable_plugin() -> void:
	_update_warnings.call_deferred()


func _disable_plugin() -> void:
	_update_warnings.call_deferred()


## Volumes warn of a plugin that is off. Not when the editor ends: there is nobody left to ask for its scene.
static func _update_warnings() -> void:
	var root := EditorInterface.get_edited_scene_root()
	if root == null:
		return
	for node in [root] + root.find_children("*", "LumivoxVolume3D", true, false):
		(node as Node).update_configuration_warnings()


func _on_selection_changed() -> void:
	for node in EditorInterface.get_selection().get_selected_nodes():
		if node is LumivoxVolume3D:
			_dock.follow_node(node as LumivoxVolume3D)
			return


## The editor copies what is dropped and imports it by extension; scanners often leave the extension out, and archives
## hold all sorts of things.
func _on_files_dropped(files: PackedStringArray) -> void:
	if files.size() == 1 and (ImportDialog.holds_unnamed_dicom(files[0]) or ImportDialog.is_dicom_archive(files[0])):
		_dialog.open_path(files[0])
